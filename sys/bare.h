#pragma once

#include "shim.h"

/* A recorded ray: 36 bytes, the layout of `Query` in src/bare.rs. */
typedef struct BareQuery {
  float origin[3];
  float t_min;
  float direction[3];
  float t_max;
  unsigned occlusion;
} BareQuery;

RTCScene bare_new_scene(RTCDevice device, bool robust);
void bare_add_triangles(RTCDevice device, RTCScene scene, const float *positions, size_t vertices,
                        const unsigned *indices, size_t triangles);
/* How many hit. With `packets`, neighbours that ask for the nearest hit go eight at a time. */
size_t bare_trace(RTCScene scene, const BareQuery *queries, size_t count, bool packets);
