// Facets that rays can be traced through, on Embree 3.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "capture/simulated/virtual_room/facets.h"

struct RTCSceneTy;
struct RTCDeviceTy;

namespace raywalk::capture {

// Room units; the direction is a unit vector.
struct Ray {
  Eigen::Vector3d origin{0, 0, 0};
  Eigen::Vector3d direction{0, 0, 1};
};

// The first facet a ray meets.
struct Hit {
  int facet = -1;         // -1: none
  double distance = 0.0;  // along the ray
  // Position between the corners: (0, 0) at the first, (1, 0) at the second, (0, 1) at the last,
  // linear over the two triangles that the diagonal from the second to the last one divides.
  float u = 0.0F, v = 0.0F;
};

// Safe to use from several threads at once.
class EmbreeScene {
 public:
  // Throws Error if Embree cannot be started or runs out of memory.
  explicit EmbreeScene(std::span<const Facet> facets);

  // hits[i] is what rays[i] meets; the spans are of equal length. Embree computes in single
  // precision, so it only finds the facet: the distance is that to the facet's plane in double
  // precision.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
  Hit intersect(const Ray& ray) const;

  // Whether anything lies on the ray nearer than `distance`.
  bool occluded(const Ray& ray, double distance) const;

 private:
  struct Release {
    void operator()(RTCDeviceTy* device) const;
    void operator()(RTCSceneTy* scene) const;
  };
  struct Plane {
    Eigen::Vector3d normal;
    double offset;  // normal . p of its points
  };

  double distance_to_plane(const Ray& ray, int facet, double embree_distance) const;

  std::vector<Plane> planes_;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
};

}  // namespace raywalk::capture
