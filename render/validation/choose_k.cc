#include "render/validation/choose_k.h"

#include <optional>
#include <utility>
#include <vector>

#include "core/room/connection_errors.h"
#include "core/room/connection_model.h"

namespace raywalk::render {
namespace {

// Generations whose measurement is used, in order of preference.
std::vector<Generation> measurements_for(Generation generation) {
  switch (generation) {
    case Generation::kInitial:
      return {Generation::kInitial};
    case Generation::kHlfVd:
      return {Generation::kHlfVd, Generation::kTwoSided, Generation::kInitial};
    case Generation::kTwoSided:
      return {Generation::kTwoSided, Generation::kHlfVd, Generation::kInitial};
  }
  return {};
}

std::optional<AutoK> measured_k(const std::vector<MeasuredConnection>& measurements,
                                Generation generation) {
  for (const Generation wanted : measurements_for(generation)) {
    const std::string name = generation_name(wanted);
    for (const MeasuredConnection& measurement : measurements) {
      if (measurement.generation != name) continue;
      return AutoK{measurement.k_deg, "measured E_connect of " + name + " views"};
    }
  }
  return std::nullopt;
}

}  // namespace

AutoK auto_k_deg(const Room& room, Generation generation, const RoomRequirements* required) {
  if (room.grid().cells.empty()) return {90.0, "the room has no connections"};
  if (auto measured = measured_k(least_errors(room.directory()), generation)) {
    return *std::move(measured);
  }
  if (required != nullptr) {
    if (auto measured = measured_k(required->connection.measured, generation)) {
      measured->source += " in require.json";
      return *std::move(measured);
    }
    if (required->connection.model_k_deg) {
      return {*required->connection.model_k_deg, "model E_t in require.json"};
    }
  }
  const ConnectionModel model = connection_model(room);
  return {static_cast<double>(model.curve.optimum_k_deg),
          model.from_distances ? "model E_t over the room's distances" : "model E_t at 1.5 N"};
}

}  // namespace raywalk::render
