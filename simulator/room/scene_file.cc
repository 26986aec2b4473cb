#include "simulator/room/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/settings.h"
#include "core/files/shipped_configs.h"
#include "core/geometry/sphere.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr std::size_t kMost = 100000;  // of anything in a file
constexpr std::size_t kMostBytes = std::size_t{1} << 24;
constexpr int kDeepest = 8;  // files that include each other
constexpr double kFar_m = 1e4;

using Numbers = std::vector<double>;

Vector3d vector_of(const Numbers& numbers, std::size_t first = 0) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

enum Shape : std::size_t { kBox, kPanel, kRod, kGlobe, kQuad };

struct ShapeKey {
  const char* key;
  std::size_t count;  // of its numbers
  const char* meaning;
};

// In the order of Shape.
constexpr std::array<ShapeKey, 5> kShapeKeys{
    {{"box", 6, "x, y, z of the least corner and of the opposite one"},
     {"panel", 6, "x, y, z of the least corner and of the opposite one"},
     {"rod", 8, "x, y, z of both ends and their radii"},
     {"globe", 5, "x, y, z, radius and half height"},
     {"quad", 12, "x, y, z of its four corners"}}};

void add_shape(Shape shape, const Numbers& numbers, const Placement& place, int surface,
               std::vector<Facet>* facets) {
  const Vector3d first = vector_of(numbers);
  const auto corner = [&](std::size_t i) { return place.point(vector_of(numbers, 3 * i)); };
  switch (shape) {
    case kBox:
      return add_box(place, first, vector_of(numbers, 3), surface, facets);
    case kPanel:
      return add_panel(place, first, vector_of(numbers, 3), surface, facets);
    case kRod:
      return add_rod(place, {first, vector_of(numbers, 3), numbers[6], numbers[7]}, surface,
                     facets);
    case kGlobe:
      return add_globe(place.point(first), numbers[3], numbers[4], surface, facets);
    case kQuad:
      facets->push_back(make_quad({corner(0), corner(1), corner(2), corner(3)}, surface));
  }
}

struct MaterialKeys {
  std::string name{};
  Pattern pattern = Pattern::kPlain;
  Numbers base{0.5, 0.5, 0.5}, accent{}, size_m{1.0, 1.0};
  double period_m = 0.25, seed = 0.0;
  fs::path file{};
};

struct SolidKeys {
  std::array<Numbers, kShapeKeys.size()> shapes{};
  Numbers texture_at{}, at{0.0, 0.0, 0.0};
  fs::path mesh{};
  double yaw_deg = 0.0, scale = 1.0;
  std::string material{};
  bool shell = false, two_sided = false;
};

struct ObjectKeys {
  std::string name{};
  std::vector<SolidKeys> solids{};
};

struct InstanceKeys {
  std::string object{};
  Numbers at{0.0, 0.0, 0.0}, loop{};
  double yaw_deg = 0.0, start_m = 0.0, step_m = 0.4;
};

struct FileKeys {
  std::vector<std::string> include{};
  std::vector<MaterialKeys> materials{};
  std::vector<SolidKeys> solids{};
  std::vector<ObjectKeys> objects{};
  std::vector<InstanceKeys> instances{};
};

SettingsSchema schema_of(MaterialKeys* material) {
  SettingsSchema schema;
  schema.text("name", &material->name)
      .choice("pattern", &material->pattern, kPatterns)
      .numbers("base", &material->base, 0.0, 10.0, 3)
      .numbers("accent", &material->accent, 0.0, 10.0, 3)
      .numbers("size_m", &material->size_m, 1e-4, kFar_m, 2)
      .number("period_m", &material->period_m, 1e-4, kFar_m)
      .number("seed", &material->seed, 0.0, 4294967295.0)
      .path("file", &material->file);
  return schema;
}

SettingsSchema schema_of(SolidKeys* solid) {
  SettingsSchema schema;
  for (std::size_t i = 0; i < kShapeKeys.size(); ++i) {
    schema.numbers(kShapeKeys[i].key, &solid->shapes[i], -kFar_m, kFar_m, kShapeKeys[i].count);
  }
  schema.numbers("texture_at", &solid->texture_at, -kFar_m, kFar_m, 3)
      .path("mesh", &solid->mesh)
      .numbers("at", &solid->at, -kFar_m, kFar_m, 3)
      .number("yaw_deg", &solid->yaw_deg, -360.0, 360.0)
      .number("scale", &solid->scale, 1e-6, 1e6)
      .text("material", &solid->material)
      .boolean("shell", &solid->shell)
      .boolean("two_sided", &solid->two_sided);
  return schema;
}

SettingsSchema schema_of(InstanceKeys* instance) {
  SettingsSchema schema;
  schema.text("object", &instance->object)
      .numbers("at", &instance->at, -kFar_m, kFar_m, 3)
      .number("yaw_deg", &instance->yaw_deg, -360.0, 360.0)
      .numbers("loop", &instance->loop, -kFar_m, kFar_m, 1000)
      .number("start_m", &instance->start_m, 0.0, kFar_m)
      .number("step_m", &instance->step_m, 0.0, kFar_m);
  return schema;
}

// Binds a list of mappings to `items`.
template <typename Keys>
void bind_items(SettingsSchema* schema, const char* key, std::vector<Keys>* items) {
  schema->items(
      key,
      [items] {
        items->emplace_back();
        return schema_of(&items->back());
      },
      kMost);
}

SettingsSchema schema_of(ObjectKeys* object) {
  SettingsSchema schema;
  schema.text("name", &object->name);
  bind_items(&schema, "solids", &object->solids);
  return schema;
}

template <typename Value>
std::vector<std::string> names_of(const std::map<std::string, Value>& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

// Where the keys of one file are, for messages.
struct Source {
  std::string name;
  fs::path folder;
  SettingsLines lines{};

  // `key` is that of a value, or of a mapping: "solids[3]".
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    const auto line = lines.lower_bound(key);
    throw UsageError(line == lines.end()
                         ? fmt::format("{}: '{}' {}", name, key, what)
                         : fmt::format("{}:{}: '{}' {}", name, line->second, key, what));
  }
  void require_count(const Numbers& numbers, std::size_t count, const std::string& key,
                     const char* meaning) const {
    if (numbers.size() == count) return;
    fail(key, fmt::format("has {} numbers; it needs {}: {}", numbers.size(), count, meaning));
  }
  Vector3d vector(const Numbers& numbers, const std::string& key) const {
    require_count(numbers, 3, key, "x, y, z");
    return vector_of(numbers);
  }
  Color color(const Numbers& numbers, const std::string& key) const {
    require_count(numbers, 3, key, "red, green, blue");
    return vector_of(numbers).cast<float>();
  }
};

class SceneReader {
 public:
  // Adds the contents of a file, those of the files that it includes first.
  void read(const std::string& yaml, const std::string& name, const fs::path& folder, int depth) {
    if (depth > kDeepest) throw UsageError(name + ": files include each other");
    FileKeys keys;
    Source source{name, folder};
    source.lines = schema_of(&keys).parse(yaml, name);
    for (const std::string& included : keys.include) {
      read_file_at(config_path(included, ConfigKind::kScene, folder), depth + 1);
    }
    // Again, so that this file's own lights count and not those of the included files.
    if (!keys.include.empty()) {
      keys = {};
      schema_of(&keys).parse(yaml, name);
    }
    add(keys, source);
  }

  void read_file_at(const fs::path& file, int depth) {
    std::string yaml;
    try {
      yaml = read_file(file, kMostBytes);
    } catch (const Error& e) {
      throw UsageError(std::string("scene ") + e.what());
    }
    read(yaml, file.string(), file.parent_path(), depth);
  }

  Scene finished(const std::string& source) {
    const auto pattern_of = [&](int surface) {
      return scene_.room.surfaces[static_cast<std::size_t>(surface)].pattern;
    };
    std::vector<Facet>& facets = scene_.room.facets;
    std::ranges::copy_if(facets, std::back_inserter(scene_.glass), [&](const Facet& facet) {
      return pattern_of(facet.surface) == Pattern::kGlass;
    });
    std::erase_if(facets,
                  [&](const Facet& facet) { return pattern_of(facet.surface) == Pattern::kGlass; });
    if (facets.empty()) throw UsageError(source + ": the scene has no solids");
    for (const auto& [surface, lamp] : everything_.globes) {
      if (pattern_of(surface) == Pattern::kLamp) scene_.lights.lamps.push_back(lamp);
    }
    for (const Facet& facet : facets) {
      if (pattern_of(facet.surface) != Pattern::kSky) continue;
      const auto& corners = facet.corners;
      scene_.lights.windows.push_back(
          {corners[0], corners[1] - corners[0], corners[3] - corners[0], facet.normal});
    }
    if (!sun_.empty()) scene_.lights.sun = vector_of(sun_).normalized();
    scene_.lights.sky_seed = static_cast<std::uint32_t>(sky_seed_);
    return std::move(scene_);
  }

 private:
  using Globe = std::pair<int, LampLight>;  // surface, and its light if that is a lamp's

  struct Object {
    std::vector<Facet> facets{};
    std::vector<Globe> globes{};
  };

  SettingsSchema schema_of(FileKeys* keys) {
    SettingsSchema schema;
    schema.words("include", &keys->include, 100)
        .numbers("sun", &sun_, -1.0, 1.0, 3)
        .boolean("open_sky", &scene_.lights.open_sky)
        .number("sky_seed", &sky_seed_, 0.0, 4294967295.0)
        .number("lamp_reach_m", &scene_.lights.lamp_reach, 0.0, kFar_m)
        .number("light_step_m", &scene_.lights.grid_step, 0.01, 100.0);
    bind_items(&schema, "materials", &keys->materials);
    bind_items(&schema, "solids", &keys->solids);
    bind_items(&schema, "objects", &keys->objects);
    bind_items(&schema, "instances", &keys->instances);
    return schema;
  }

  void add(const FileKeys& keys, const Source& source) {
    if (!sun_.empty() && source.vector(sun_, "sun").isZero()) {
      source.fail("sun", "has no direction");
    }
    for (std::size_t i = 0; i < keys.materials.size(); ++i) {
      add_material(keys.materials[i], fmt::format("materials[{}]", i), source);
    }
    for (std::size_t i = 0; i < keys.solids.size(); ++i) {
      add_solid(keys.solids[i], fmt::format("solids[{}]", i), source, &everything_);
    }
    for (std::size_t i = 0; i < keys.objects.size(); ++i) {
      const ObjectKeys& keys_of = keys.objects[i];
      Object object;
      for (std::size_t j = 0; j < keys_of.solids.size(); ++j) {
        add_solid(keys_of.solids[j], fmt::format("objects[{}].solids[{}]", i, j), source, &object);
      }
      objects_[keys_of.name] = std::move(object);
    }
    for (std::size_t i = 0; i < keys.instances.size(); ++i) {
      add_instance(keys.instances[i], fmt::format("instances[{}]", i), source);
    }
    std::ranges::move(everything_.facets, std::back_inserter(scene_.room.facets));
    everything_.facets.clear();
  }

  // A material of the same name as an earlier one takes its place.
  void add_material(const MaterialKeys& keys, const std::string& key, const Source& source) {
    Surface surface;
    surface.pattern = keys.pattern;
    surface.base = source.color(keys.base, key + ".base");
    surface.accent = keys.accent.empty() ? Color(0.6F * surface.base)
                                         : source.color(keys.accent, key + ".accent");
    source.require_count(keys.size_m, 2, key + ".size_m", "width, height");
    surface.extent = {static_cast<float>(keys.size_m[0]), static_cast<float>(keys.size_m[1])};
    surface.period = static_cast<float>(keys.period_m);
    surface.seed = static_cast<std::uint32_t>(keys.seed);
    if (keys.pattern == Pattern::kPicture) {
      if (keys.file.empty()) source.fail(key, "needs a 'file' with the picture");
      try {
        surface.picture = std::make_shared<const Texture>(source.folder / keys.file);
      } catch (const Error& e) {
        source.fail(key + ".file", std::string("cannot be used: ") + e.what());
      }
    }
    auto& surfaces = scene_.room.surfaces;
    const auto [found, is_new] = materials_.emplace(keys.name, static_cast<int>(surfaces.size()));
    if (is_new) surfaces.emplace_back();
    surfaces[static_cast<std::size_t>(found->second)] = surface;
  }

  int material(const std::string& name, const std::string& key, const Source& source) const {
    const auto found = materials_.find(name);
    if (found != materials_.end()) return found->second;
    source.fail(key, "is no material: " + excerpt(name) + suggestion(name, names_of(materials_)));
  }

  void add_solid(const SolidKeys& solid, const std::string& key, const Source& source,
                 Object* object) {
    const Placement place{source.vector(solid.at, key + ".at"),
                          radians_from_degrees(solid.yaw_deg)};
    std::vector<Facet>* facets = &object->facets;
    const std::size_t first = facets->size();
    if (!solid.mesh.empty()) add_mesh(solid, place, key, source, facets);
    for (std::size_t kind = 0; kind < kShapeKeys.size(); ++kind) {
      const Numbers& numbers = solid.shapes[kind];
      if (numbers.empty()) continue;
      const std::string shape = fmt::format("{}.{}", key, kShapeKeys[kind].key);
      source.require_count(numbers, kShapeKeys[kind].count, shape, kShapeKeys[kind].meaning);
      const int surface = material(solid.material, key + ".material", source);
      add_shape(static_cast<Shape>(kind), numbers, place, surface, facets);
      const bool has_size = std::all_of(
          facets->begin() + static_cast<std::ptrdiff_t>(first), facets->end(),
          [](const Facet& facet) { return facet.normal.norm() > 0.5; });  // also false for NaN
      if (!has_size) source.fail(shape, "has no size");
      if (kind == kGlobe) {
        object->globes.push_back({surface, {place.point(vector_of(numbers)), numbers[3]}});
      }
    }
    if (facets->size() == first) source.fail(key, "needs a box, panel, rod, globe, quad or mesh");
    for (std::size_t i = first; i < facets->size(); ++i) {
      Facet& facet = (*facets)[i];
      facet.shell = solid.shell;
      facet.two_sided = solid.two_sided;
      if (solid.texture_at.empty()) continue;
      facet.texture.origin = place.point(source.vector(solid.texture_at, key + ".texture_at"));
    }
  }

  void add_mesh(const SolidKeys& solid, const Placement& place, const std::string& key,
                const Source& source, std::vector<Facet>* facets) {
    Facets mesh;
    try {
      mesh = read_mesh(source.folder / solid.mesh);
    } catch (const Error& e) {
      source.fail(key + ".mesh", std::string("cannot be used: ") + e.what());
    }
    auto& surfaces = scene_.room.surfaces;
    const auto first = static_cast<int>(surfaces.size());
    surfaces.insert(surfaces.end(), mesh.surfaces.begin(), mesh.surfaces.end());
    const bool own = solid.material.empty();
    for (Facet facet : mesh.facets) {
      for (Vector3d& corner : facet.corners) corner *= solid.scale;
      facet.texture.origin *= solid.scale;
      facet.texture.s_axis /= solid.scale;
      facet.texture.t_axis /= solid.scale;
      facet.surface =
          own ? first + facet.surface : material(solid.material, key + ".material", source);
      facets->push_back(moved(facet, place.rotation(), place.origin));
    }
  }

  void add_instance(const InstanceKeys& keys, const std::string& key, const Source& source) {
    const auto found = objects_.find(keys.object);
    if (found == objects_.end()) {
      source.fail(key + ".object", "is no object: " + excerpt(keys.object) +
                                       suggestion(keys.object, names_of(objects_)));
    }
    const Vector3d at = source.vector(keys.at, key + ".at");
    const Object& object = found->second;
    if (!keys.loop.empty()) {
      MovingObject moving{object.facets, {}, at.y(), keys.start_m, keys.step_m};
      for (std::size_t i = 0; i + 1 < keys.loop.size(); i += 2) {
        moving.loop.emplace_back(keys.loop[i], keys.loop[i + 1]);
      }
      if (keys.loop.size() % 2 != 0 || moving.loop.front() == moving.loop.back()) {
        source.fail(key + ".loop", "needs x and z of two corners or more, the last not the first");
      }
      scene_.moving.push_back(std::move(moving));
      return;
    }
    const Placement place{at, radians_from_degrees(keys.yaw_deg)};
    for (const Facet& facet : object.facets) {
      everything_.facets.push_back(moved(facet, place.rotation(), place.origin));
    }
    for (auto [surface, lamp] : object.globes) {
      lamp.centre = place.point(lamp.centre);
      everything_.globes.emplace_back(surface, lamp);
    }
  }

  Scene scene_;
  std::map<std::string, int> materials_;  // index of the surface
  std::map<std::string, Object> objects_;
  Object everything_;
  Numbers sun_;
  double sky_seed_ = 0.0;
};

}  // namespace

Placement MovingObject::at(int moment) const {
  const auto corner = [&](std::size_t i) { return loop[i % loop.size()]; };
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) length += (corner(i + 1) - corner(i)).norm();
  double left = std::fmod(start_m + step_m * moment, length);
  std::size_t side = 0;
  while (left > (corner(side + 1) - corner(side)).norm() && side + 1 < loop.size()) {
    left -= (corner(side + 1) - corner(side)).norm();
    ++side;
  }
  const Eigen::Vector2d along = (corner(side + 1) - corner(side)).normalized();
  const Eigen::Vector2d here = corner(side) + left * along;
  return {{here.x(), height_m, here.y()}, std::atan2(along.x(), along.y())};
}

Scene read_scene(const fs::path& file) {
  SceneReader reader;
  reader.read_file_at(file, 0);
  return reader.finished(file.string());
}

Scene parse_scene(const std::string& yaml, const std::string& source, const fs::path& folder) {
  SceneReader reader;
  reader.read(yaml, source, folder, 0);
  return reader.finished(source);
}

}  // namespace raywalk::simulator
