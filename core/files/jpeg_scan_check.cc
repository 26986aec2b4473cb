#include "core/files/jpeg_scan_check.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

namespace raywalk {
namespace {

constexpr int kCodeBits = 16;  // of the longest Huffman code
constexpr int kMarkerByte = 0xFF;
constexpr int kFirstRestart = 0xD0;

// A Huffman table by the next 16 bits of the data.
class CodeTable {
 public:
  struct Code {
    std::uint8_t bits = 0;  // 0: no code begins so
    std::uint8_t symbol = 0;
  };

  // T.81, annex C: codes of a length are consecutive numbers. None if the lengths need more codes
  // than there are.
  static std::optional<CodeTable> of(const JHUFF_TBL& definition) {
    CodeTable table;
    std::size_t next = 0, symbol = 0;
    for (int bits = 1; bits <= kCodeBits; ++bits) {
      const std::size_t width = std::size_t{1} << (kCodeBits - bits);
      for (int i = 0; i < definition.bits[bits]; ++i, ++symbol, next += width) {
        if (next + width > table.codes_.size() || symbol >= std::size(definition.huffval)) {
          return std::nullopt;
        }
        for (std::size_t w = 0; w < width; ++w) {
          table.codes_[next + w] = {static_cast<std::uint8_t>(bits), definition.huffval[symbol]};
        }
      }
    }
    return table;
  }

  Code starting(unsigned next_bits) const { return codes_[next_bits]; }

 private:
  std::vector<Code> codes_{std::vector<Code>(std::size_t{1} << kCodeBits)};
};

// The bits of an interval between markers, without the zero bytes that are stuffed behind 0xFF
// (T.81, B.1.1.5). Zeros behind the end.
class IntervalBits {
 public:
  explicit IntervalBits(std::span<const JOCTET> data) : data_(data) {}

  unsigned next16() {
    if (held_ < kCodeBits) fill();
    return static_cast<unsigned>(buffer_ >> (held_ - kCodeBits)) & 0xFFFFU;
  }
  // At most 16.
  int take(int bits) {
    const unsigned value = next16() >> (kCodeBits - bits);
    held_ -= bits;
    return static_cast<int>(value);
  }
  bool passed_end() const { return held_ < behind_end_; }
  // Padding fills the last byte (T.81, F.1.2.3).
  bool at_end() {
    fill();
    return !passed_end() && held_ - behind_end_ < 8 && behind_end_ > 0;
  }
  // Goes on behind a restart marker of this number.
  bool restart(int number) {
    if (!at_end()) return false;
    while (at_ + 1 < data_.size() && data_[at_ + 1] == kMarkerByte) ++at_;  // fill bytes
    if (at_ + 1 >= data_.size() || data_[at_ + 1] != kFirstRestart + number) return false;
    at_ += 2;
    buffer_ = 0;
    held_ = behind_end_ = 0;
    return true;
  }

 private:
  // Many bytes at once, for speed.
  void fill() {
    constexpr int kMost = 56;
    while (held_ <= kMost) {
      int byte = 0;
      if (at_ < data_.size() && data_[at_] != kMarkerByte) {
        byte = data_[at_++];
      } else if (at_ + 1 < data_.size() && data_[at_ + 1] == 0) {
        byte = kMarkerByte;
        at_ += 2;
      } else {
        behind_end_ += 8;
      }
      buffer_ = buffer_ << 8 | static_cast<std::uint64_t>(byte);
      held_ += 8;
    }
  }

  std::span<const JOCTET> data_;
  std::size_t at_ = 0;
  std::uint64_t buffer_ = 0;
  int held_ = 0;        // bits in the buffer
  int behind_end_ = 0;  // of these, zeros behind the end
};

// A colour component of the scan.
struct Component {
  const CodeTable* mean_codes;  // of DC coefficients
  const CodeTable* codes;       // of AC coefficients
  int blocks;                   // per minimum coded unit
  int largest_mean;             // of a quantised DC coefficient
  int mean = 0;                 // of the block before
};

constexpr const char* kNoCode = "bits that are no code";
constexpr const char* kRange = "a value outside of the range of samples";
constexpr const char* kLongBlock = "a block with more than 64 coefficients";

// Reads one block; what is wrong with it, or null. T.81, F.2.2.
const char* block_damage(Component* component, IntervalBits* bits) {
  constexpr int kMostMeanBits = 11, kMostBits = 10, kZeroRun = 15, kCoefficients = 64;
  const CodeTable::Code mean = component->mean_codes->starting(bits->next16());
  if (mean.bits == 0) return kNoCode;
  if (mean.symbol > kMostMeanBits) return kRange;
  bits->take(mean.bits);
  if (mean.symbol > 0) {
    const int value = bits->take(mean.symbol);
    const bool negative = value < 1 << (mean.symbol - 1);
    component->mean += negative ? value - (1 << mean.symbol) + 1 : value;
    if (std::abs(component->mean) > component->largest_mean) return kRange;
  }
  for (int k = 1; k < kCoefficients; ++k) {
    const CodeTable::Code code = component->codes->starting(bits->next16());
    if (code.bits == 0) return kNoCode;
    bits->take(code.bits);
    const int run = code.symbol >> 4, size = code.symbol & 15;
    if (size == 0 && run != kZeroRun) return run == 0 ? nullptr : kNoCode;
    if (size > kMostBits) return kRange;
    k += run;
    if (k >= kCoefficients) return kLongBlock;
    if (size > 0) bits->take(size);
  }
  return nullptr;
}

// The tables that a scan uses, by class (DC, AC) and number; null where a table is missing.
class ScanTables {
 public:
  const CodeTable* get(JHUFF_TBL* const* definitions, int number, bool of_means) {
    if (number < 0 || number >= NUM_HUFF_TBLS) return nullptr;
    auto& table = tables_[of_means ? 0 : 1][static_cast<std::size_t>(number)];
    if (!table && definitions[number] != nullptr) table = CodeTable::of(*definitions[number]);
    return table ? &*table : nullptr;
  }

 private:
  std::array<std::array<std::optional<CodeTable>, NUM_HUFF_TBLS>, 2> tables_;
};

// Empty for scans that are not examined.
std::vector<Component> components_of(const jpeg_decompress_struct& info, ScanTables* tables) {
  constexpr int kLargestMean = 1024;  // of samples from -128 to 127 (T.81, A.3.3)
  std::vector<Component> components;
  if (info.progressive_mode || info.arith_code || info.data_precision != 8 ||
      info.comps_in_scan != info.num_components) {
    return {};
  }
  for (int i = 0; i < info.comps_in_scan; ++i) {
    const jpeg_component_info& each = *info.cur_comp_info[i];
    // libjpeg examines the numbers of tables when it starts to decode.
    const bool numbered = each.quant_tbl_no >= 0 && each.quant_tbl_no < NUM_QUANT_TBLS;
    const JQUANT_TBL* steps = numbered ? info.quant_tbl_ptrs[each.quant_tbl_no] : nullptr;
    const CodeTable* means = tables->get(info.dc_huff_tbl_ptrs, each.dc_tbl_no, true);
    const CodeTable* others = tables->get(info.ac_huff_tbl_ptrs, each.ac_tbl_no, false);
    if (steps == nullptr || steps->quantval[0] == 0 || means == nullptr || others == nullptr) {
      return {};
    }
    const int blocks = info.comps_in_scan == 1 ? 1 : each.h_samp_factor * each.v_samp_factor;
    components.push_back({means, others, blocks, kLargestMean / steps->quantval[0] + 1});
  }
  return components;
}

std::int64_t units_of(const jpeg_decompress_struct& info) {
  int across = 1, down = 1;  // blocks
  for (int i = 0; i < info.comps_in_scan && info.comps_in_scan > 1; ++i) {
    across = std::max(across, info.cur_comp_info[i]->h_samp_factor);
    down = std::max(down, info.cur_comp_info[i]->v_samp_factor);
  }
  const auto units = [](JDIMENSION pixels, int blocks) {
    return (std::int64_t{pixels} + DCTSIZE * blocks - 1) / (DCTSIZE * blocks);
  };
  return units(info.image_width, across) * units(info.image_height, down);
}

}  // namespace

std::string scan_damage(const jpeg_decompress_struct& info) {
  constexpr int kRestartNumbers = 8;
  ScanTables tables;
  std::vector<Component> components = components_of(info, &tables);
  if (components.empty()) return {};
  IntervalBits bits({info.src->next_input_byte, info.src->bytes_in_buffer});
  const std::int64_t units = units_of(info);
  const std::int64_t interval = info.restart_interval == 0 ? units : info.restart_interval;
  for (std::int64_t unit = 0; unit < units; ++unit) {
    if (unit > 0 && unit % interval == 0) {
      if (!bits.restart(static_cast<int>((unit / interval - 1) % kRestartNumbers))) {
        return "a restart marker is not where it should be";
      }
      for (Component& component : components) component.mean = 0;
    }
    for (Component& component : components) {
      for (int block = 0; block < component.blocks; ++block) {
        if (const char* damage = block_damage(&component, &bits)) return damage;
      }
    }
    if (bits.passed_end()) return "data are missing";
  }
  return bits.at_end() ? std::string() : "extraneous data before the end";
}

}  // namespace raywalk
