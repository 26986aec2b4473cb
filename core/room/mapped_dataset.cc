#include "core/room/mapped_dataset.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

struct Element {
  hid_t type;
  std::size_t bytes;
  const char* name;
};

Element element_of(ElementType type) {
  switch (type) {
    case ElementType::kUint8:
      return {H5T_STD_U8LE, 1, "uint8"};
    case ElementType::kFloat32:
      return {H5T_IEEE_F32LE, 4, "float32"};
    case ElementType::kInt32:
      return {H5T_STD_I32LE, 4, "int32"};
    case ElementType::kUint64:
      return {H5T_STD_U64LE, 8, "uint64"};
  }
  throw Error("unknown element type");
}

// The byte range of a dataset in its file.
struct Extent {
  std::vector<std::size_t> shape;
  std::size_t offset = 0;
  std::size_t bytes = 0;
};

std::size_t bytes_of(const std::vector<std::size_t>& shape, std::size_t element_bytes,
                     const std::string& name) {
  std::size_t bytes = element_bytes;
  for (std::size_t extent : shape) {
    if (extent == 0) throw Error(name + " is empty");
    if (bytes > std::numeric_limits<std::size_t>::max() / 2 / extent) {
      throw Error(name + " has an impossible shape");
    }
    bytes *= extent;
  }
  return bytes;
}

Extent locate(const fs::path& path, const std::string& dataset_name, const Element& element) {
  const std::string name = fmt::format("{}: dataset '{}'", path.string(), dataset_name);
  const Hdf5File file = Hdf5File::open(path);
  const Hdf5Handle dataset = file.open_dataset(dataset_name);
  const Hdf5Handle type(H5Dget_type(dataset.get()), H5Tclose);
  if (type.get() < 0 || H5Tequal(type.get(), element.type) <= 0) {
    throw Error(fmt::format("{} is not of type {}", name, element.name));
  }
  const Hdf5Handle properties(H5Dget_create_plist(dataset.get()), H5Pclose);
  if (properties.get() < 0 || H5Pget_layout(properties.get()) != H5D_CONTIGUOUS ||
      H5Pget_external_count(properties.get()) != 0) {
    throw Error(name + " is not stored contiguously; pack the room again");
  }
  Extent extent;
  extent.shape = file.shape_of(dataset_name);
  extent.bytes = bytes_of(extent.shape, element.bytes, name);
  const haddr_t offset = H5Dget_offset(dataset.get());
  if (offset == HADDR_UNDEF) throw Error(name + " has never been written");
  extent.offset = static_cast<std::size_t>(offset);
  if (extent.offset % element.bytes != 0)
    throw Error(name + " is not aligned; pack the room again");
  return extent;
}

std::size_t page_bytes() {
  static const auto bytes = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return bytes;
}

// The start of the page of a mapped byte, as madvise and mincore require.
std::byte* page_of(const void* byte) {
  auto* at = const_cast<std::byte*>(static_cast<const std::byte*>(byte));
  return at - reinterpret_cast<std::uintptr_t>(at) % page_bytes();
}

// A file descriptor, needed only until the mapping exists.
class ReadDescriptor {
 public:
  explicit ReadDescriptor(const fs::path& file) : fd_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (fd_ < 0) {
      throw Error(fmt::format("{}: {}", file.string(), std::generic_category().message(errno)));
    }
  }
  ~ReadDescriptor() { ::close(fd_); }
  ReadDescriptor(const ReadDescriptor&) = delete;
  ReadDescriptor& operator=(const ReadDescriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

MappedDataset::MappedDataset(MappedDataset&& other) noexcept { *this = std::move(other); }

MappedDataset& MappedDataset::operator=(MappedDataset&& other) noexcept {
  std::swap(mapping_, other.mapping_);
  std::swap(mapping_bytes_, other.mapping_bytes_);
  std::swap(data_, other.data_);
  std::swap(shape_, other.shape_);
  return *this;
}

MappedDataset::~MappedDataset() {
  if (mapping_ != nullptr) ::munmap(mapping_, mapping_bytes_);
}

MappedDataset MappedDataset::open(const fs::path& file, const std::string& dataset,
                                  ElementType type) {
  const Extent extent = locate(file, dataset, element_of(type));
  const ReadDescriptor descriptor(file);
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) {
    throw Error(fmt::format("{}: {}", file.string(), std::generic_category().message(errno)));
  }
  const auto file_bytes = static_cast<std::size_t>(status.st_size);
  // Touching a mapped page past the end of the file would kill the process (SIGBUS).
  if (extent.offset > file_bytes || extent.bytes > file_bytes - extent.offset) {
    throw Error(fmt::format("{}: dataset '{}' is cut short: {} of {} bytes are there",
                            file.string(), dataset,
                            file_bytes - std::min(file_bytes, extent.offset), extent.bytes));
  }
  // mmap wants an offset that is a whole number of pages.
  const std::size_t page = page_bytes();
  // Also maps the preceding page, if any: vector loads may begin a few bytes early.
  const std::size_t before = extent.offset % page + (extent.offset >= page ? page : 0);
  MappedDataset mapped;
  // An empty page follows: vector loads may end a few bytes late.
  const std::size_t file_pages = (before + extent.bytes + page - 1) / page * page;
  mapped.mapping_bytes_ = file_pages + page;
  void* mapping =
      ::mmap(nullptr, mapped.mapping_bytes_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapping != MAP_FAILED) {
    void* const reserved = std::exchange(
        mapping, ::mmap(mapping, before + extent.bytes, PROT_READ, MAP_SHARED | MAP_FIXED,
                        descriptor.get(), static_cast<off_t>(extent.offset - before)));
    if (mapping == MAP_FAILED) ::munmap(reserved, mapped.mapping_bytes_);
  }
  if (mapping == MAP_FAILED) {
    throw Error(fmt::format("{}: cannot be mapped into memory: {}", file.string(),
                            std::generic_category().message(errno)));
  }
  mapped.mapping_ = mapping;
  mapped.data_ = static_cast<const std::byte*>(mapping) + before;
  mapped.shape_ = extent.shape;
  return mapped;
}

void MappedDataset::fetch(const void* begin, std::size_t bytes) const {
  // Linux reads at most the disk's read-ahead size per call, by default 128 KiB.
  constexpr std::size_t kPiece = std::size_t{128} << 10;
  std::byte* at = page_of(begin);
  std::byte* const end = const_cast<std::byte*>(static_cast<const std::byte*>(begin)) + bytes;
  for (; at < end; at += kPiece) {
    ::madvise(at, std::min(kPiece, static_cast<std::size_t>(end - at)), MADV_WILLNEED);
  }
}

bool MappedDataset::in_memory(const void* byte) const {
  unsigned char resident = 1;
  return ::mincore(page_of(byte), 1, &resident) != 0 || (resident & 1U) != 0;
}

void MappedDataset::expect_scattered_reads() const {
  ::madvise(mapping_, mapping_bytes_, MADV_RANDOM);
}

}  // namespace raywalk
