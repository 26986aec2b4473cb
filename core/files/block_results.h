// What the blocks of a long step leave until they are merged: a file for each block, in a folder
// that all machines see.
//
// The folder is named after the inputs and the number of blocks, so there is no state to agree on:
// a block is done where its file exists, blocks of other inputs are never merged, and two processes
// at the same block write the same bytes, of which the later rename stays.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/block.h"

namespace raywalk {

class BlockResults {
 public:
  // The results of `step` (a word such as "validate", for names and messages) that are kept in
  // `folder`. `inputs`: a fingerprint, hexadecimal, of all that determines the results: rooms,
  // tables, options. Creates nothing.
  //
  // `whole`: of results that a block leaves elsewhere as well, whether they are there; a block
  // without them is not done.
  BlockResults(std::filesystem::path folder, std::string step, std::string inputs,
               std::function<bool(Block)> whole = nullptr);

  bool done(Block block) const;
  // Calls `make` for the result of a block and stores it, unless that block is done. Returns
  // whether it was made now. Throws Error where the folder cannot be written, and what `make`
  // throws.
  bool make(Block block, const std::function<std::string()>& make) const;

  // make(), and a line for the user that says whether the block was done now or before.
  std::string make_and_tell(Block block, const std::function<std::string()>& make) const;

  // The results in order, of the number of blocks that is complete. Throws Error if none is: it
  // names the blocks that are missing.
  std::vector<std::string> merged() const;

  // The number of blocks that is complete; none: missing() says why.
  std::optional<int> complete_count() const;
  // The result of a block that is done.
  std::string result_of(Block block) const;
  // Which blocks are missing, for people; empty if a number of blocks is complete.
  std::string missing() const;
  bool any_done() const;
  // Of the numbers of blocks that were begun, the one with the largest share done; `if_none` if
  // there is none.
  int count_to_complete(int if_none = 1) const;

  // Removes the results of the step, also those of other inputs. What cannot be removed stays.
  void remove() const;

 private:
  std::filesystem::path directory_of(int count) const;
  std::filesystem::path file_of(Block block) const;
  std::vector<int> started_counts() const;       // increasing
  std::vector<int> missing_of(int count) const;  // increasing

  std::filesystem::path folder_;
  std::string step_;
  std::string inputs_;
  std::function<bool(Block)> whole_;
};

// Where the blocks of an output are kept that has no place for them inside: "room.lf.blocks".
std::filesystem::path blocks_beside(const std::filesystem::path& output);

}  // namespace raywalk
