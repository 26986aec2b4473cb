// Meshes of Wavefront OBJ files.
#include <tiny_obj_loader.h>

#include <Eigen/Dense>
#include <string>

#include "core/base/error.h"
#include "simulator/room/scene_file.h"
#include "simulator/room/shapes.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

Vector3d vector_at(const std::vector<tinyobj::real_t>& values, int index) {
  const auto first = 3 * static_cast<std::size_t>(index);
  // OBJ files are right-handed: their z is backwards.
  return {values[first], values[first + 1], -static_cast<double>(values[first + 2])};
}

Eigen::Vector2d texture_at(const tinyobj::attrib_t& values, int index) {
  const auto first = 2 * static_cast<std::size_t>(index);
  return {values.texcoords[first], values.texcoords[first + 1]};
}

// The frame whose coordinates at the triangle's corners are `at`.
TextureFrame frame_of(const std::array<Vector3d, 3>& corners,
                      const std::array<Eigen::Vector2d, 3>& at) {
  Eigen::Matrix<double, 3, 2> edges, changes = Eigen::Matrix<double, 3, 2>::Zero();
  edges << corners[1] - corners[0], corners[2] - corners[0];
  changes.topRows<2>() << at[1] - at[0], at[2] - at[0];
  // In the plane of the triangle, so a combination of its edges.
  const Eigen::Matrix<double, 3, 2> inverse =
      edges * (edges.transpose() * edges).completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::Matrix<double, 3, 2> axes = inverse * changes.topRows<2>().transpose();
  return {corners[0], axes.col(0), axes.col(1), at[0]};
}

Surface surface_of(const tinyobj::material_t& material, const std::filesystem::path& folder) {
  Surface surface;
  surface.base = {static_cast<float>(material.diffuse[0]), static_cast<float>(material.diffuse[1]),
                  static_cast<float>(material.diffuse[2])};
  if (material.diffuse_texname.empty()) return surface;
  surface.pattern = Pattern::kPicture;
  surface.picture = std::make_shared<const Texture>(folder / material.diffuse_texname);
  return surface;
}

}  // namespace

Facets read_mesh(const std::filesystem::path& file) {
  tinyobj::ObjReader reader;  // divides polygons into triangles
  if (!reader.ParseFromFile(file.string())) {
    throw Error(file.string() + ": " + one_line(reader.Error()));
  }
  Facets mesh;
  for (const tinyobj::material_t& material : reader.GetMaterials()) {
    mesh.surfaces.push_back(surface_of(material, file.parent_path()));
  }
  mesh.surfaces.emplace_back();  // of faces without a material
  const tinyobj::attrib_t& values = reader.GetAttrib();
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    for (std::size_t face = 0; face < shape.mesh.material_ids.size(); ++face) {
      const tinyobj::index_t* index = &shape.mesh.indices[3 * face];
      std::array<Vector3d, 3> corners;
      for (std::size_t i = 0; i < 3; ++i)
        corners[i] = vector_at(values.vertices, index[i].vertex_index);
      const int material = shape.mesh.material_ids[face];
      const auto surface = material < 0 ? static_cast<int>(mesh.surfaces.size()) - 1 : material;
      Facet facet = make_quad({corners[0], corners[1], corners[2], corners[2]}, surface);
      if (!(facet.normal.norm() > 0.5)) continue;  // no area
      if (index[0].normal_index >= 0) {
        for (std::size_t i = 0; i < 4; ++i) {
          facet.corner_normals[i] =
              vector_at(values.normals, index[std::min<std::size_t>(i, 2)].normal_index);
        }
      }
      if (index[0].texcoord_index >= 0) {
        facet.texture = frame_of(corners, {texture_at(values, index[0].texcoord_index),
                                           texture_at(values, index[1].texcoord_index),
                                           texture_at(values, index[2].texcoord_index)});
      }
      mesh.facets.push_back(facet);
    }
  }
  if (mesh.facets.empty()) throw Error(file.string() + ": no faces");
  return mesh;
}

}  // namespace raywalk::simulator
