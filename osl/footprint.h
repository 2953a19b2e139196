// SPDX-License-Identifier: Apache-2.0
//
// The pixel that sees a point, and the area of its projection on the surface: see core/footprint.h.
#pragma once

struct Pixel {
  int x;
  int y;
  float area;  // on the surface, scene units squared
  point raster;
  int projects;  // whether that is the place in the picture: of a camera's ray, and no panorama
};

int pixel_coordinate(float raster)
{
  return (int)floor(clamp(raster, -1e9, 1e9));
}

float facing_area(vector view_in_camera, float pixels_x, float pixels_y)
{
  return fabs(view_in_camera[2]) / (length(view_in_camera) * pixels_x * pixels_y);
}

float surface_area(float exact, float differential, float cos_view)
{
  if (exact > 0.2 * differential && exact < 5.0 * differential)
    return exact / cos_view;
  return differential / cos_view;
}

// n is the shading normal: the count of a coarse, smooth mesh does not show its facets, and the mean radiance does not
// depend on the area at all.
Pixel find_pixel(point position, vector n, vector view)
{
  Pixel pixel;
  pixel.raster = transform("raster", position);
  pixel.x = pixel_coordinate(pixel.raster[0]);
  pixel.y = pixel_coordinate(pixel.raster[1]);
  float exact = 0.0;
  if (raytype("camera")) {
    point c = transform("camera", position);
    vector towards = transform("camera", view);
    float h = max(fabs(c[2]), 1e-30);
    // Across the camera's axis x alone moves along the raster's x, and y along its y.
    point aside = transform("raster", position + transform("camera", "common", vector(h, h, 0.0)));
    point behind = transform("raster", position - view * h);
    float x = fabs(aside[0] - pixel.raster[0]);
    float y = fabs(aside[1] - pixel.raster[1]);
    // A projection keeps the place in the raster along the view, but for the depth of field; a panorama has no such raster.
    if (fabs(behind[0] - pixel.raster[0]) < 0.1 * x && fabs(behind[1] - pixel.raster[1]) < 0.1 * y)
      exact = facing_area(towards, x / h, y / h);
  }
  pixel.projects = exact > 0.0;
  pixel.area = surface_area(exact, length(cross(Dx(position), Dy(position))), max(dot(n, view), 1e-6));
  return pixel;
}
