/* What a C program would write, and nothing more: the limit that a renderer is measured against. */

#include "bare.h"

RTCScene bare_new_scene(RTCDevice device, bool robust) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  return scene;
}

void bare_add_triangles(RTCDevice device, RTCScene scene, const float *positions, size_t vertices,
                        const unsigned *indices, size_t triangles) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryMask(geometry, 0xffffffffu);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0,
                             16, vertices);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12,
                             triangles);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

static bool trace_one(RTCScene scene, const BareQuery *q) {
  struct RTCRayHit query;
  query.ray.org_x = q->origin[0];
  query.ray.org_y = q->origin[1];
  query.ray.org_z = q->origin[2];
  query.ray.tnear = q->t_min;
  query.ray.dir_x = q->direction[0];
  query.ray.dir_y = q->direction[1];
  query.ray.dir_z = q->direction[2];
  query.ray.time = 0.0f;
  query.ray.tfar = q->t_max;
  query.ray.mask = 0xffffffffu;
  query.ray.flags = 0;
  if (q->occlusion) {
    telamon_occluded1(scene, &query.ray, NULL);
    return query.ray.tfar < 0.0f;
  }
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  telamon_intersect1(scene, &query, NULL);
  return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

static size_t trace_eight(RTCScene scene, const BareQuery *queries, size_t count) {
  _Alignas(32) int valid[8];
  struct RTCRayHit8 query;
  for (size_t i = 0; i < 8; i++) {
    const BareQuery *q = &queries[i < count ? i : 0];
    valid[i] = i < count ? -1 : 0;
    query.ray.org_x[i] = q->origin[0];
    query.ray.org_y[i] = q->origin[1];
    query.ray.org_z[i] = q->origin[2];
    query.ray.tnear[i] = q->t_min;
    query.ray.dir_x[i] = q->direction[0];
    query.ray.dir_y[i] = q->direction[1];
    query.ray.dir_z[i] = q->direction[2];
    query.ray.time[i] = 0.0f;
    query.ray.tfar[i] = q->t_max;
    query.ray.mask[i] = 0xffffffffu;
    query.ray.id[i] = (unsigned)i;
    query.ray.flags[i] = 0;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  telamon_intersect8(valid, scene, &query, false, NULL);
  size_t hits = 0;
  for (size_t i = 0; i < count; i++)
    hits += query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
  return hits;
}

size_t bare_trace(RTCScene scene, const BareQuery *queries, size_t count, bool packets) {
  size_t hits = 0;
  for (size_t i = 0; i < count;) {
    size_t run = 1;
    if (packets && !queries[i].occlusion) {
      while (run < 8 && i + run < count && !queries[i + run].occlusion)
        run++;
      hits += trace_eight(scene, &queries[i], run);
    } else {
      hits += trace_one(scene, &queries[i]);
    }
    i += run;
  }
  return hits;
}
