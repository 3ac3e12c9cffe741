/* What Rust calls in place of the parts of Embree that bindgen cannot see (inline functions) or that
   differ between 3.13 and 4. Everything else is called directly. */

#pragma once

#include "wrapper.h"

/* What a query's own code needs to know of it; it has to live until the query ends. `accept` is asked of each hit
   that an occlusion query finds on a geometry with `telamon_filter_occlusion`, and says whether it counts; the
   query goes on past those that do not. `ray` is the ray's `id` field. User geometries get `user` with each ray. */
typedef struct ShimQuery {
  const void *user;
  bool (*accept)(const void *user, unsigned int ray, unsigned int geometry, unsigned int primitive,
                 float t);
} ShimQuery;

/* Ray queries. The masks of packets are Embree's: eight numbers aligned to 32 bytes, -1 for a lane
   that is traced and 0 for one that is not. `coherent` is Embree's hint; with it, a packet may
   miss what a ray of it meets on an edge. Single rays have no such hint. `query` may be null: then all hits count. */
void telamon_intersect1(RTCScene scene, struct RTCRayHit *rayhit, const ShimQuery *query);
void telamon_occluded1(RTCScene scene, struct RTCRay *ray, const ShimQuery *query);
void telamon_intersect8(const int *valid, RTCScene scene, struct RTCRayHit8 *rayhit, bool coherent,
                        const ShimQuery *query);
void telamon_occluded8(const int *valid, RTCScene scene, struct RTCRay8 *ray, bool coherent,
                       const ShimQuery *query);

/* Has `ShimQuery.accept` asked of this geometry's hits in occlusion queries. */
void telamon_filter_occlusion(RTCGeometry geometry);

/* A ray as a user geometry sees it: in the geometry's space, which under an instance is the
   instance's, so the direction need not be a unit vector. t_max is the closest hit so far. */
typedef struct ShimRay {
  float origin[3];
  float t_min;
  float direction[3];
  float t_max;
  float time;
  unsigned int id;    /* the ray's `id` field */
  const void *user;   /* `ShimQuery.user`; null if there is no such query */
} ShimRay;

/* A hit on a user geometry; the normal is in the geometry's space and of any length. `primitive` is what
   Embree's struct gets as such: a primitive of the geometry may have more inside than Embree knows of.
   `instance` likewise, unless it is RTC_INVALID_GEOMETRY_ID: then the hit has the instance that Embree is
   in, if any. */
typedef struct ShimHit {
  float t;
  float u;
  float v;
  float normal[3];
  unsigned int primitive;
  unsigned int instance;
} ShimHit;

/* The callbacks of a user geometry. All three must be set. They run on several threads at once.
   `intersect` returns whether it filled `hit` (which arrives zeroed) with the closest t in
   [ray.t_min, ray.t_max]; `occluded` returns whether there is any such t. */
typedef struct ShimUserGeometry {
  const void *user;
  void (*bounds)(const void *user, unsigned int primitive, unsigned int time_step,
                 struct RTCBounds *bounds);
  bool (*intersect)(const void *user, unsigned int primitive, const ShimRay *ray, ShimHit *hit);
  bool (*occluded)(const void *user, unsigned int primitive, const ShimRay *ray);
} ShimUserGeometry;

/* Makes `callbacks` answer for a geometry of type RTC_GEOMETRY_TYPE_USER. It is kept as the
   geometry's user data, not copied: it must stay where it is until the geometry is gone. */
void telamon_set_user_geometry(RTCGeometry geometry, const ShimUserGeometry *callbacks);

/* Explains an error that rtcGetDeviceError returned on this thread: Embree's own words from 4.3.3
   on, even for the device NULL that rtcNewDevice could not make; before that a sentence per code.
   Valid until the next call on this thread that fails. */
const char *telamon_error_message(RTCDevice device, enum RTCError error);

/* What the C compiler thinks; the test compares it with what Rust thinks. */
typedef struct ShimLayout {
  size_t ray;
  size_t ray_align;
  size_t hit;
  size_t ray_hit;
  size_t ray_hit_align;
  size_t ray8;
  size_t ray_hit8;
  size_t ray_hit8_align;
  size_t bounds;
  size_t shim_ray;
  size_t shim_hit;
  size_t shim_query;
  size_t shim_user_geometry;
} ShimLayout;

ShimLayout telamon_layout(void);
