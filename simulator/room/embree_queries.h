// Rays through a scene of Embree 3 (Debian 12) or 4 (Debian 13): the same queries, whose arguments
// differ between the two.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace raywalk::capture {

#if RTC_VERSION_MAJOR >= 4

// valid[i] is -1 for a ray of the packet that counts and 0 for one that does not. All rays have
// similar origins and directions.
inline void find_hits(RTCScene scene, const int* valid, RTCRayHit8* rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, rays, &arguments);
}

inline void find_hit(RTCScene scene, RTCRayHit* ray) { rtcIntersect1(scene, ray); }

// Embree sets tfar = -inf for an occluded ray.
inline void find_occlusion(RTCScene scene, RTCRay* ray) { rtcOccluded1(scene, ray); }

#else

inline void find_hits(RTCScene scene, const int* valid, RTCRayHit8* rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, rays);
}

inline void find_hit(RTCScene scene, RTCRayHit* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, ray);
}

inline void find_occlusion(RTCScene scene, RTCRay* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
}

#endif

}  // namespace raywalk::capture
