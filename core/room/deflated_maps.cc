#include "core/room/deflated_maps.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk {

DeflatedMaps::DeflatedMaps(const Hdf5File& hdf5)
    : path_(hdf5.path()), shape_(hdf5.shape_of("distance_m")) {
  const bool is_usable = shape_.size() == 3 && shape_[0] > 0 && shape_[1] > 0 && shape_[2] > 0 &&
                         shape_[1] < (std::size_t{1} << 20) && shape_[2] < (std::size_t{1} << 20) &&
                         hdf5.shape_of("confidence") == shape_;
  if (!is_usable) {
    throw Error(path_.string() + ": 'distance_m' and 'confidence' are not both [map][theta][phi]");
  }
  distance_m_.chunks = hdf5.deflated_chunks(distance_m_.name, H5T_IEEE_F32LE);
  confidence_.chunks = hdf5.deflated_chunks(confidence_.name, H5T_STD_U8LE);
  loaded_ = std::vector<std::once_flag>(shape_[0]);
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) {
    throw Error(fmt::format("{}: {}", path_.string(), std::generic_category().message(errno)));
  }
  reserve(&distance_m_);
  reserve(&confidence_);
}

DeflatedMaps::~DeflatedMaps() {
  for (const Dataset* dataset : {&distance_m_, &confidence_}) {
    if (dataset->memory != nullptr) ::munmap(dataset->memory, shape_[0] * map_bytes(*dataset));
  }
  if (file_ >= 0) ::close(file_);
}

std::size_t DeflatedMaps::map_bytes(const Dataset& dataset) const {
  return shape_[1] * shape_[2] * dataset.element_bytes;
}

void DeflatedMaps::reserve(Dataset* dataset) const {
  void* const memory = ::mmap(nullptr, shape_[0] * map_bytes(*dataset), PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) {
    throw Error(fmt::format("{}: no address space for its maps: {}", path_.string(),
                            std::generic_category().message(errno)));
  }
  dataset->memory = memory;
}

void DeflatedMaps::load(std::size_t map) {
  std::call_once(loaded_[map], [&] {
    decode(distance_m_, map);
    decode(confidence_, map);
  });
}

void DeflatedMaps::decode(const Dataset& dataset, std::size_t map) const {
  const auto [begin, stored_bytes, deflated] = dataset.chunks[map];
  const std::size_t bytes = map_bytes(dataset);
  std::vector<std::uint8_t> stored(std::min<std::uint64_t>(stored_bytes, ::compressBound(bytes)));
  const ssize_t read = ::pread(file_, stored.data(), stored.size(), static_cast<off_t>(begin));
  std::vector<std::uint8_t> shuffled(bytes);
  bool intact = read == static_cast<ssize_t>(stored.size());
  if (deflated) {
    uLongf decoded = bytes;
    intact = intact &&
             ::uncompress(shuffled.data(), &decoded, stored.data(), stored.size()) == Z_OK &&
             decoded == bytes;
  } else {
    intact = intact && stored.size() == bytes;
    shuffled.swap(stored);
  }
  if (!intact) {
    throw Error(fmt::format("{}: map {} of '{}' is damaged; restore the file from a copy",
                            path_.string(), map, dataset.name));
  }
  // Shuffled: first the first bytes of all numbers, then the second bytes, ...
  auto* const out = static_cast<std::uint8_t*>(dataset.memory) + map * bytes;
  const std::size_t count = bytes / dataset.element_bytes;
  for (std::size_t byte = 0; byte < dataset.element_bytes; ++byte) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i * dataset.element_bytes + byte] = shuffled[byte * count + i];
    }
  }
}

}  // namespace raywalk
