// Meshes of Wavefront OBJ files.
#pragma once

#include <filesystem>

#include "simulator/room/shapes.h"

namespace raywalk::simulator {

// The triangles of the file in its own frame and unit, with its materials: colour and picture of
// the diffuse reflectance (Kd, map_Kd). y is up; the normals of its vertices, where it has them,
// shade curved surfaces. Throws Error naming the file if it or a picture cannot be read.
Facets read_mesh(const std::filesystem::path& file);

}  // namespace raywalk::simulator
