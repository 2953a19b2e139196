// SPDX-License-Identifier: Apache-2.0
//
// The space in which the paint's flakes rest: see core/own_space.h.
#pragma once

#include "elementary.h"

struct OwnSpace {
  point position;
  vector x;
  vector y;
  vector z;
  int instance;
};

vector own_direction(OwnSpace own, vector d)
{
  return vector(inner_product(own.x, d), inner_product(own.y, d), inner_product(own.z, d));
}

struct LatticePlane {
  vector n;
  int w;
  int u;
  int v;
  int face;
};

LatticePlane lattice_plane(OwnSpace own, vector surface_normal)
{
  vector n = own_direction(own, surface_normal);
  LatticePlane plane;
  plane.n = n;
  plane.w = 0;
  if (fabs(n[1]) > fabs(n[0]))
    plane.w = 1;
  if (fabs(n[2]) > max(fabs(n[0]), fabs(n[1])))
    plane.w = 2;
  plane.u = (plane.w + 1) % 3;
  plane.v = (plane.w + 2) % 3;
  plane.face = plane.w;
  if (n[plane.w] < 0.0)
    plane.face = plane.w + 3;
  return plane;
}

// Without a rest position the own space is the object's in world units
// along each of its axes. With one, which the surface's deformation leaves alone, directions turn as the surface's tangents do.
OwnSpace find_own_space(point position, float meters, vector rest)
{
  // Its columns are as long as the object's scale shrinks them. Each transform() by name would ask the renderer anew.
  matrix to_object = matrix("common", "object");
  OwnSpace own;
  float random = 0.0;
  getattribute("object:random", random);
  own.instance = (int)(random * 16777216.0);
  own.x = vector(to_object[0][0], to_object[1][0], to_object[2][0]);
  own.y = vector(to_object[0][1], to_object[1][1], to_object[2][1]);
  own.z = vector(to_object[0][2], to_object[1][2], to_object[2][2]);
  vector scale = vector(length(own.x), length(own.y), length(own.z));
  own.x = own.x / scale[0];
  own.y = own.y / scale[1];
  own.z = own.z / scale[2];
  point local = transform(to_object, position);
  int given = rest[0] != 0.0 || rest[1] != 0.0 || rest[2] != 0.0;
  if (given)
    local = point(rest);
  own.position = point(local[0] / scale[0], local[1] / scale[1], local[2] / scale[2]) * meters;
  if (given) {
    vector along = Dx(own.position);
    vector up = cross(along, Dy(own.position));
    vector world_along = Dx(position);
    vector world_up = cross(world_along, Dy(position));
    if (length(up) > 0.0 && length(world_up) > 0.0) {
      vector a = normalize(along);
      vector c = normalize(up);
      vector b = cross(c, a);
      vector world_a = normalize(world_along);
      vector world_c = normalize(world_up);
      vector world_b = cross(world_c, world_a);
      own.x = world_a * a[0] + world_b * b[0] + world_c * c[0];
      own.y = world_a * a[1] + world_b * b[1] + world_c * c[1];
      own.z = world_a * a[2] + world_b * b[2] + world_c * c[2];
    }
  }
  return own;
}
