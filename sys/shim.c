#include "shim.h"

#include <math.h>

/* ---- Layouts -----------------------------------------------------------------------------------
   Embree hands user geometries their rays as arrays of fields, N lanes each, and the accessors for
   them exist in C++ only. The enums below are those accessors' numbers, and the assertions tie them
   to the structs that the C header does declare. */

enum { ORG_X, ORG_Y, ORG_Z, TNEAR, DIR_X, DIR_Y, DIR_Z, TIME, TFAR, MASK, RAY_ID, RAY_FIELDS = 12 };
enum { NG_X, NG_Y, NG_Z, HIT_U, HIT_V, PRIM_ID, GEOM_ID, INST_ID };

#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
enum { INST_PRIM_ID = INST_ID + RTC_MAX_INSTANCE_LEVEL_COUNT };
enum { HIT_FIELDS = INST_PRIM_ID + RTC_MAX_INSTANCE_LEVEL_COUNT };
#else
enum { HIT_FIELDS = INST_ID + RTC_MAX_INSTANCE_LEVEL_COUNT };
#endif

#define ROUND_UP(n, to) (((n) + (to) - 1) / (to) * (to))
#define ASSERT_FIELD(type, field, index, lanes)                                                    \
  _Static_assert(offsetof(struct type, field) == (index) * (lanes) * 4, #type "." #field)
#define ASSERT_LAYOUT(suffix, lanes, align)                                                        \
  _Static_assert(sizeof(struct RTCRay##suffix) == RAY_FIELDS * lanes * 4, "size of a ray");        \
  _Static_assert(sizeof(struct RTCHit##suffix) == ROUND_UP(HIT_FIELDS * lanes * 4, align),         \
                 "size of a hit");                                                                 \
  _Static_assert(_Alignof(struct RTCRay##suffix) == align, "alignment of a ray");                  \
  _Static_assert(_Alignof(struct RTCRayHit##suffix) == align, "alignment of a ray and hit");       \
  _Static_assert(sizeof(struct RTCRayHit##suffix) ==                                               \
                     sizeof(struct RTCRay##suffix) + sizeof(struct RTCHit##suffix),                \
                 "size of a ray and hit");                                                         \
  ASSERT_FIELD(RTCRay##suffix, org_x, ORG_X, lanes);                                               \
  ASSERT_FIELD(RTCRay##suffix, tnear, TNEAR, lanes);                                               \
  ASSERT_FIELD(RTCRay##suffix, dir_x, DIR_X, lanes);                                               \
  ASSERT_FIELD(RTCRay##suffix, time, TIME, lanes);                                                 \
  ASSERT_FIELD(RTCRay##suffix, tfar, TFAR, lanes);                                                 \
  ASSERT_FIELD(RTCRay##suffix, id, RAY_ID, lanes);                                                 \
  ASSERT_FIELD(RTCRayHit##suffix, hit, RAY_FIELDS, lanes);                                         \
  ASSERT_FIELD(RTCHit##suffix, Ng_x, NG_X, lanes);                                                 \
  ASSERT_FIELD(RTCHit##suffix, u, HIT_U, lanes);                                                   \
  ASSERT_FIELD(RTCHit##suffix, v, HIT_V, lanes);                                                   \
  ASSERT_FIELD(RTCHit##suffix, primID, PRIM_ID, lanes);                                            \
  ASSERT_FIELD(RTCHit##suffix, geomID, GEOM_ID, lanes);                                            \
  ASSERT_FIELD(RTCHit##suffix, instID, INST_ID, lanes)

ASSERT_LAYOUT(, 1, 16);
ASSERT_LAYOUT(8, 8, 32);
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
ASSERT_FIELD(RTCHit, instPrimID, INST_PRIM_ID, 1);
ASSERT_FIELD(RTCHit8, instPrimID, INST_PRIM_ID, 8);
#endif

_Static_assert(sizeof(float) == 4 && sizeof(unsigned int) == 4, "a lane is four bytes");
_Static_assert(sizeof(struct RTCBounds) == 32, "bounds are two padded points");
_Static_assert(offsetof(struct RTCBounds, upper_x) == 16, "the upper corner comes second");
/* bindgen does not evaluate the cast in this macro, so lib.rs writes the number out. */
_Static_assert(RTC_INVALID_GEOMETRY_ID == 0xFFFFFFFFu, "lib.rs has another number");

ShimLayout telamon_layout(void) {
  return (ShimLayout){
      .ray = sizeof(struct RTCRay),
      .ray_align = _Alignof(struct RTCRay),
      .hit = sizeof(struct RTCHit),
      .ray_hit = sizeof(struct RTCRayHit),
      .ray_hit_align = _Alignof(struct RTCRayHit),
      .ray8 = sizeof(struct RTCRay8),
      .ray_hit8 = sizeof(struct RTCRayHit8),
      .ray_hit8_align = _Alignof(struct RTCRayHit8),
      .bounds = sizeof(struct RTCBounds),
      .shim_ray = sizeof(ShimRay),
      .shim_hit = sizeof(ShimHit),
      .shim_query = sizeof(ShimQuery),
      .shim_user_geometry = sizeof(ShimUserGeometry),
  };
}

/* ---- Ray queries ----------------------------------------------------------------------------- */

/* The context that Embree hands to callbacks, with what they need behind it. */
#if RTC_VERSION_MAJOR == 3

typedef struct Context {
  struct RTCIntersectContext base;
  const ShimQuery *query;
} Context;

_Static_assert(offsetof(struct RTCIntersectContext, instID) == 16, "context: flags, filter, ids");

static inline Context context_for(bool coherent, const ShimQuery *query) {
  Context context = {.query = query};
  rtcInitIntersectContext(&context.base);
  if (coherent) context.base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

void telamon_intersect1(RTCScene scene, struct RTCRayHit *rayhit, const ShimQuery *query) {
  Context context = context_for(false, query);
  rtcIntersect1(scene, &context.base, rayhit);
}

void telamon_occluded1(RTCScene scene, struct RTCRay *ray, const ShimQuery *query) {
  Context context = context_for(false, query);
  rtcOccluded1(scene, &context.base, ray);
}

void telamon_intersect8(const int *valid, RTCScene scene, struct RTCRayHit8 *rayhit, bool coherent,
                        const ShimQuery *query) {
  Context context = context_for(coherent, query);
  rtcIntersect8(valid, scene, &context.base, rayhit);
}

void telamon_occluded8(const int *valid, RTCScene scene, struct RTCRay8 *ray, bool coherent,
                       const ShimQuery *query) {
  Context context = context_for(coherent, query);
  rtcOccluded8(valid, scene, &context.base, ray);
}

#else

typedef struct Context {
  struct RTCRayQueryContext base;
  const ShimQuery *query;
} Context;

_Static_assert(offsetof(struct RTCRayQueryContext, instID) ==
                   (RTC_MAX_INSTANCE_LEVEL_COUNT > 1 ? 4 : 0),
               "context: stack size if there can be a stack, ids");

static inline Context context_for(const ShimQuery *query) {
  Context context = {.query = query};
  rtcInitRayQueryContext(&context.base);
  return context;
}

static inline struct RTCIntersectArguments intersect_arguments(Context *context, bool coherent) {
  struct RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context->base;
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}

static inline struct RTCOccludedArguments occluded_arguments(Context *context, bool coherent) {
  struct RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context->base;
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}

void telamon_intersect1(RTCScene scene, struct RTCRayHit *rayhit, const ShimQuery *query) {
  Context context = context_for(query);
  struct RTCIntersectArguments arguments = intersect_arguments(&context, false);
  rtcIntersect1(scene, rayhit, &arguments);
}

void telamon_occluded1(RTCScene scene, struct RTCRay *ray, const ShimQuery *query) {
  Context context = context_for(query);
  struct RTCOccludedArguments arguments = occluded_arguments(&context, false);
  rtcOccluded1(scene, ray, &arguments);
}

void telamon_intersect8(const int *valid, RTCScene scene, struct RTCRayHit8 *rayhit, bool coherent,
                        const ShimQuery *query) {
  Context context = context_for(query);
  struct RTCIntersectArguments arguments = intersect_arguments(&context, coherent);
  rtcIntersect8(valid, scene, rayhit, &arguments);
}

void telamon_occluded8(const int *valid, RTCScene scene, struct RTCRay8 *ray, bool coherent,
                       const ShimQuery *query) {
  Context context = context_for(query);
  struct RTCOccludedArguments arguments = occluded_arguments(&context, coherent);
  rtcOccluded8(valid, scene, ray, &arguments);
}

#endif

/* ---- Filter ----------------------------------------------------------------------------------- */

static void occlusion_filter(const struct RTCFilterFunctionNArguments *args) {
  const ShimQuery *query = ((const Context *)args->context)->query;
  if (!query) return;
  const unsigned int n = args->N;
  const float *ray = (const float *)args->ray;
  const unsigned int *ray_ids = (const unsigned int *)args->ray;
  const unsigned int *hit = (const unsigned int *)args->hit;

  for (unsigned int i = 0; i < n; i++) {
    if (args->valid[i] != -1) continue;
    if (!query->accept(query->user, ray_ids[RAY_ID * n + i], hit[GEOM_ID * n + i],
                       hit[PRIM_ID * n + i], ray[TFAR * n + i]))
      args->valid[i] = 0;
  }
}

void telamon_filter_occlusion(RTCGeometry geometry) {
  rtcSetGeometryOccludedFilterFunction(geometry, occlusion_filter);
}

/* ---- User geometry --------------------------------------------------------------------------- */

static ShimRay ray_of_lane(const float *ray, unsigned int n, unsigned int i, const void *context) {
  const ShimQuery *query = ((const Context *)context)->query;
  return (ShimRay){
      .origin = {ray[ORG_X * n + i], ray[ORG_Y * n + i], ray[ORG_Z * n + i]},
      .t_min = ray[TNEAR * n + i],
      .direction = {ray[DIR_X * n + i], ray[DIR_Y * n + i], ray[DIR_Z * n + i]},
      .t_max = ray[TFAR * n + i],
      .time = ray[TIME * n + i],
      .id = ((const unsigned int *)ray)[RAY_ID * n + i],
      .user = query ? query->user : NULL,
  };
}

static void bounds_callback(const struct RTCBoundsFunctionArguments *args) {
  const ShimUserGeometry *shape = args->geometryUserPtr;
  shape->bounds(shape->user, args->primID, args->timeStep, args->bounds_o);
}

static void intersect_callback(const struct RTCIntersectFunctionNArguments *args) {
  const ShimUserGeometry *shape = args->geometryUserPtr;
  const unsigned int n = args->N;
  float *ray = (float *)args->rayhit;
  float *hit = ray + RAY_FIELDS * n;
  unsigned int *ids = (unsigned int *)hit;

  for (unsigned int i = 0; i < n; i++) {
    if (args->valid[i] != -1) continue;
    const ShimRay lane = ray_of_lane(ray, n, i, args->context);
    ShimHit found = {0};
    if (!shape->intersect(shape->user, args->primID, &lane, &found)) continue;

    ray[TFAR * n + i] = found.t;
    hit[NG_X * n + i] = found.normal[0];
    hit[NG_Y * n + i] = found.normal[1];
    hit[NG_Z * n + i] = found.normal[2];
    hit[HIT_U * n + i] = found.u;
    hit[HIT_V * n + i] = found.v;
    ids[PRIM_ID * n + i] = found.primitive;
    ids[GEOM_ID * n + i] = args->geomID;
    for (unsigned int level = 0; level < RTC_MAX_INSTANCE_LEVEL_COUNT; level++) {
      ids[(INST_ID + level) * n + i] = args->context->instID[level];
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
      ids[(INST_PRIM_ID + level) * n + i] = args->context->instPrimID[level];
#endif
    }
    if (found.instance != RTC_INVALID_GEOMETRY_ID) ids[INST_ID * n + i] = found.instance;
  }
}

static void occluded_callback(const struct RTCOccludedFunctionNArguments *args) {
  const ShimUserGeometry *shape = args->geometryUserPtr;
  const unsigned int n = args->N;
  float *ray = (float *)args->ray;

  for (unsigned int i = 0; i < n; i++) {
    if (args->valid[i] != -1) continue;
    const ShimRay lane = ray_of_lane(ray, n, i, args->context);
    if (shape->occluded(shape->user, args->primID, &lane)) ray[TFAR * n + i] = -INFINITY;
  }
}

void telamon_set_user_geometry(RTCGeometry geometry, const ShimUserGeometry *callbacks) {
  /* Embree's user data is not const; nothing here or in Embree writes through it. */
  rtcSetGeometryUserData(geometry, (void *)callbacks);
  rtcSetGeometryBoundsFunction(geometry, bounds_callback, NULL);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback);
}

/* ---- Errors ---------------------------------------------------------------------------------- */

const char *telamon_error_message(RTCDevice device, enum RTCError error) {
#if RTC_VERSION >= 40303
  (void)error;
  return rtcGetDeviceLastErrorMessage(device);
#else
  (void)device;
  switch (error) {
    case RTC_ERROR_NONE: return "no error";
    case RTC_ERROR_UNKNOWN: return "unknown error";
    case RTC_ERROR_INVALID_ARGUMENT: return "invalid argument";
    case RTC_ERROR_INVALID_OPERATION: return "invalid operation";
    case RTC_ERROR_OUT_OF_MEMORY: return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU: return "unsupported CPU (Embree needs SSE2 at least)";
    case RTC_ERROR_CANCELLED: return "cancelled";
    default: return "an error code that Embree's header does not list";
  }
#endif
}
