// For tests: a disk in memory that is full or loses power at a given operation, and then keeps only
// what fsync guarantees.
#pragma once

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "capture/session/disk_layer.h"

namespace raywalk::capture {

// A power loss. Not a std::exception, so that no code of the program cleans up after it.
struct PowerLoss {};

class LossyDisk final : public DiskLayer {
 public:
  // The operation (from 0) at which power is lost, or the disk is full; -1: never.
  int power_lost_at = -1;
  int full_at = -1;

  int operations() const { return operations_; }
  // The file names in the directory before the power loss.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& [path, inode] : now_) names.push_back(path.filename().string());
    return names;
  }

  std::unique_ptr<DiskFile> create(const std::filesystem::path& file) override {
    begin();
    if (now_.contains(file)) fail(EEXIST);
    return std::make_unique<File>(this, make_entry(file));
  }
  void rename_new(const std::filesystem::path& from, const std::filesystem::path& to) override {
    begin();
    if (now_.contains(to)) fail(EEXIST);
    now_[to] = now_.at(from);
    now_.erase(from);
    steps_.push_back(now_);
  }
  void sync_directory(const std::filesystem::path& /*directory*/) override {
    begin();
    steps_ = {now_};
  }
  void remove(const std::filesystem::path& file) override {
    begin();
    now_.erase(file);
    steps_.push_back(now_);
  }

  // Writes a possible state after the power loss into the real file system: any number of the
  // changes to the directory since its last sync; of each file the synced bytes and any part of the
  // rest, possibly as zeros.
  void write_remains(std::mt19937* random) const {
    for (const auto& [path, inode] : steps_[below(random, steps_.size())]) {
      const std::size_t unsynced = inode->content.size() - inode->synced;
      std::string content = inode->content.substr(0, inode->synced + below(random, unsynced + 1));
      if (below(random, 2) == 0) std::fill(content.begin() + inode->synced, content.end(), '\0');
      std::ofstream(path, std::ios::binary) << content;
    }
  }

 private:
  struct Inode {
    std::string content;
    std::ptrdiff_t synced = 0;  // number of bytes guaranteed to be on the disk
  };
  using Directory = std::map<std::filesystem::path, std::shared_ptr<Inode>>;

  class File final : public DiskFile {
   public:
    File(LossyDisk* disk, std::shared_ptr<Inode> inode) : disk_(disk), inode_(std::move(inode)) {}
    void write(std::span<const std::byte> bytes) override {
      // The first half is written before a fault.
      const auto* text = reinterpret_cast<const char*>(bytes.data());
      inode_->content.append(text, bytes.size() / 2);
      disk_->begin();
      inode_->content.append(text + bytes.size() / 2, bytes.size() - bytes.size() / 2);
    }
    void sync() override {
      disk_->begin();
      inode_->synced = static_cast<std::ptrdiff_t>(inode_->content.size());
    }
    void close() override { disk_->begin(); }

   private:
    LossyDisk* disk_;
    std::shared_ptr<Inode> inode_;
  };

  static std::size_t below(std::mt19937* random, std::size_t end) { return (*random)() % end; }
  [[noreturn]] static void fail(int error) {
    throw std::system_error(error, std::generic_category(), "disk");
  }
  void begin() {
    const int operation = operations_++;
    if (power_lost_at >= 0 && operation >= power_lost_at) throw PowerLoss();
    if (operation == full_at) fail(ENOSPC);
  }
  std::shared_ptr<Inode> make_entry(const std::filesystem::path& file) {
    auto inode = std::make_shared<Inode>();
    now_[file] = inode;
    steps_.push_back(now_);
    return inode;
  }

  int operations_ = 0;
  Directory now_;
  std::vector<Directory> steps_{Directory{}};  // at the last sync and after every change since
};

}  // namespace raywalk::capture
