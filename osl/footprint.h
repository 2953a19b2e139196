// SPDX-License-Identifier: Apache-2.0
//
// The pixel that sees a point, and the area of its projection on the surface. Cycles' own Dx(P), Dy(P) are traced as a
// cone: |Dx x Dy| lacks the 1/cos(theta).
#pragma once

struct Pixel {
  int x;
  int y;
  float area;  // on the surface, scene units squared
  point raster;
};

int pixel_coordinate(float raster)
{
  return (int)floor(clamp(raster, -1e9, 1e9));
}

// Perspective and orthographic cameras: with the camera-space point c and pixels s_x, s_y per unit length across the view at its
// depth, an area A facing along V covers A |V_z|/|V| s_x s_y pixels; a tilted one 1/cos(theta) as much area.
// n is the shading normal: the count of a coarse, smooth mesh does not show its facets, and the mean radiance does not
// depend on the area at all. Everywhere else (seen in a mirror, other cameras) the ray differentials, corrected by 1/cos(theta).
Pixel find_pixel(point position, vector n, vector view)
{
  Pixel pixel;
  pixel.raster = transform("raster", position);
  pixel.x = pixel_coordinate(pixel.raster[0]);
  pixel.y = pixel_coordinate(pixel.raster[1]);
  float cos_view = max(dot(n, view), 1e-6);
  float differential = length(cross(Dx(position), Dy(position)));
  pixel.area = differential / cos_view;
  if (raytype("camera")) {
    point c = transform("camera", position);
    float h = max(fabs(c[2]), 1e-30);
    point centre = transform("camera", "raster", c);
    point right = transform("camera", "raster", c + vector(h, 0.0, 0.0));
    point up = transform("camera", "raster", c + vector(0.0, h, 0.0));
    float s_x = fabs(right[0] - centre[0]) / h;
    float s_y = fabs(up[1] - centre[1]) / h;
    vector v_camera = transform("camera", view);
    float exact = fabs(v_camera[2]) / (length(v_camera) * s_x * s_y);
    // A camera without a projection matrix (panorama) gives nonsense here, far from the traced cone.
    if (exact > 0.2 * differential && exact < 5.0 * differential)
      pixel.area = exact / cos_view;
  }
  return pixel;
}
