#include "core/room/mapped_dataset.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk {
namespace {

// The start of the page of a mapped byte, as madvise requires.
std::byte* page_of(const void* byte) {
  auto* at = const_cast<std::byte*>(static_cast<const std::byte*>(byte));
  return at - reinterpret_cast<std::uintptr_t>(at) % page_bytes();
}

}  // namespace

std::size_t page_bytes() {
  static const auto bytes = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return bytes;
}

MappedDataset::MappedDataset(const Hdf5File& hdf5, const std::string& dataset, ElementType type) {
  const FilePlace place = hdf5.place_of(dataset, type);
  begin_ = place.begin;
  // mmap wants an offset that is a whole number of pages. Also maps the preceding page, if any:
  // vector loads may begin a few bytes early.
  const std::size_t page = page_bytes();
  const std::size_t before = begin_ % page + (begin_ >= page ? page : 0);
  // An empty page follows: vector loads may end a few bytes late.
  mapping_bytes_ = (before + place.bytes + page - 1) / page * page + page;
  void* const reserved =
      ::mmap(nullptr, mapping_bytes_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (reserved != MAP_FAILED) mapping_ = reserved;
  file_ = ::open(hdf5.path().c_str(), O_RDONLY | O_CLOEXEC);
  if (mapping_ == nullptr || file_ < 0 ||
      ::mmap(mapping_, before + place.bytes, PROT_READ, MAP_SHARED | MAP_FIXED, file_,
             static_cast<off_t>(begin_ - before)) == MAP_FAILED) {
    const int number = errno;
    release();
    throw Error(fmt::format("{}: cannot be mapped into memory: {}", hdf5.path().string(),
                            std::generic_category().message(number)));
  }
  data_ = static_cast<const std::byte*>(mapping_) + before;
}

MappedDataset::~MappedDataset() { release(); }

void MappedDataset::release() {
  if (mapping_ != nullptr) ::munmap(mapping_, mapping_bytes_);
  if (file_ >= 0) ::close(file_);
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

// Not by mincore, which calls files that the caller may not write always in memory.
bool MappedDataset::in_memory(const void* byte) const {
  char read = 0;
  const iovec into{&read, 1};
  const auto at = static_cast<const std::byte*>(byte) - data_;
  return ::preadv2(file_, &into, 1, static_cast<off_t>(begin_) + at, RWF_NOWAIT) >= 0 ||
         errno != EAGAIN;
}

void MappedDataset::expect_scattered_reads() const {
  ::madvise(mapping_, mapping_bytes_, MADV_RANDOM);
}

}  // namespace raywalk
