/* SPDX-License-Identifier: MIT */
/** Embree 3 and 4 alike: how a ray is asked for, and what of the query its filters see. */
#ifndef FNL_RAY_EMBREE_H
#define FNL_RAY_EMBREE_H

#if FANAL_EMBREE >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext embree_query;
static inline void embree_query_init(embree_query *query) { rtcInitRayQueryContext(query); }
static inline void embree_intersect(RTCScene scene, embree_query *query, struct RTCRayHit *ray) {
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = query;
    rtcIntersect1(scene, ray, &arguments);
}
static inline void embree_occluded(RTCScene scene, embree_query *query, struct RTCRay *ray) {
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = query;
    rtcOccluded1(scene, ray, &arguments);
}
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext embree_query;
static inline void embree_query_init(embree_query *query) { rtcInitIntersectContext(query); }
static inline void embree_intersect(RTCScene scene, embree_query *query, struct RTCRayHit *ray) {
    rtcIntersect1(scene, query, ray);
}
static inline void embree_occluded(RTCScene scene, embree_query *query, struct RTCRay *ray) {
    rtcOccluded1(scene, query, ray);
}
#endif

#endif
