// Ray tracing of facets with Embree.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "simulator/room/shapes.h"

struct RTCSceneTy;
struct RTCDeviceTy;

namespace raywalk::simulator {

// Room units; the direction is a unit vector.
struct Ray {
  Eigen::Vector3d origin{0, 0, 0};
  Eigen::Vector3d direction{0, 0, 1};
};

// The first facet that a ray hits.
struct Hit {
  int facet = -1;         // -1: none
  double distance = 0.0;  // along the ray
  // Position on the facet: (0, 0) at the first corner, (1, 0) at the second, (0, 1) at the last;
  // linear on the two triangles on either side of the diagonal from the second to the last.
  float u = 0.0F, v = 0.0F;
};

// Safe to use from several threads at once.
class EmbreeScene {
 public:
  // Throws Error if Embree cannot be initialized or runs out of memory.
  explicit EmbreeScene(std::span<const Facet> facets);

  // The first hit of the ray. Embree works in single precision, so it only finds the facet; the
  // distance to its plane is computed in double precision.
  Hit intersect(const Ray& ray) const;

  // Whether the ray hits anything nearer than `distance`.
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

}  // namespace raywalk::simulator
