// SPDX-License-Identifier: Apache-2.0
//
// The pixel that sees a point, and the area of its projection on the surface.
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

// n is the shading normal: the count of a coarse, smooth mesh does not show its facets, and the mean radiance does not
// depend on the area at all.
Pixel find_pixel(point position, vector n, vector view)
{
  Pixel pixel;
  pixel.raster = transform("raster", position);
  pixel.x = pixel_coordinate(pixel.raster[0]);
  pixel.y = pixel_coordinate(pixel.raster[1]);
  pixel.projects = 0;
  if (raytype("camera")) {
    // A projection keeps the place in the raster along the view, but for the depth of field; a panorama has no such raster.
    // Across the camera's axis x alone moves along the raster's x, and y along its y.
    vector seen = transform("camera", position);
    float h = max(fabs(seen[2]), 1e-30);
    vector aside = transform("raster", position + transform("camera", "common", vector(h, h, 0.0))) - pixel.raster;
    vector behind = transform("raster", position - view * h) - pixel.raster;
    pixel.projects = fabs(behind[0]) < 0.1 * fabs(aside[0]) && fabs(behind[1]) < 0.1 * fabs(aside[1]);
  }
  // Cycles traces the differentials as a cone: dP^2 is the pixel's area across the view.
  pixel.area = length(cross(Dx(position), Dy(position))) / max(dot(n, view), 1e-6);
  return pixel;
}
