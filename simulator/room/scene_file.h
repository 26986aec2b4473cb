// A scene as data: a YAML file of materials, solids, meshes, objects and their instances.
// docs/simulator.md describes every key.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "simulator/room/light_map.h"
#include "simulator/room/shapes.h"

namespace raywalk::simulator {

// An object that is elsewhere at every station: it walks round a loop, facing where it goes.
struct MovingObject {
  std::vector<Facet> facets{};          // in its own frame
  std::vector<Eigen::Vector2d> loop{};  // corners (x, z), at least two that differ
  double height_m = 0.0;                // y of the loop
  double start_m = 0.0;                 // along the loop at the first station
  double step_m = 0.0;                  // from one station to the next

  // While station `moment` is captured, counted from 0.
  Placement at(int moment) const;
};

// Metres; x to the right, y up, z forward.
struct Scene {
  Facets room{};               // what stands still, except panes of glass
  std::vector<Facet> glass{};  // with surfaces of `room`
  std::vector<MovingObject> moving{};
  LightSources lights{};
};

// Throws UsageError as SettingsSchema does, also for a material or object that is not there, a
// solid without size, a mesh or picture that cannot be read; it names the file and the line.
Scene read_scene(const std::filesystem::path& file);

// The same of a text, which messages call `source`; its files are relative to `folder`.
Scene parse_scene(const std::string& yaml, const std::string& source,
                  const std::filesystem::path& folder = {});

// The triangles of a Wavefront OBJ file in its own frame and unit, with its materials: colour and
// picture of the diffuse reflectance (Kd, map_Kd). y is up; the normals of its vertices, where it
// has them, shade curved surfaces. Throws Error naming the file if it or a picture cannot be read.
Facets read_mesh(const std::filesystem::path& file);

}  // namespace raywalk::simulator
