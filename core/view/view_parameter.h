// A parameter: a parameter of a view that a user may turn, with all that is said of it anywhere.
// The table of them is kViewParameters (view_options.h). Flags and their help, keys of settings
// files, checks of ranges, settings in JSON, names of settings in reports and the sweep of a trade
// are made from it.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

namespace raywalk {

struct ViewOptions;

enum class ParameterKind {
  kNumber,
  kInteger,
  kChoice,  // of names; also a member that is on or off
};

// Where the help of a command lists the flag.
enum class ParameterGroup { kView, kConnection, kTrade };

// A few values, as a constant expression.
class ParameterValues {
 public:
  constexpr ParameterValues() = default;
  constexpr ParameterValues(std::initializer_list<double> values) : count_(values.size()) {
    std::size_t i = 0;
    for (const double value : values) values_.at(i++) = value;
  }
  constexpr const double* begin() const { return values_.data(); }
  constexpr const double* end() const { return values_.data() + count_; }

 private:
  std::array<double, 4> values_{};
  std::size_t count_ = 0;
};

// What a trade measures of a parameter, one value at a time, from the central setting.
struct ParameterSweep {
  ParameterValues values{};
  bool of_truth_width = false;      // the values are shares of the truths' width
  bool of_two_sided_views = false;  // others have none of it
};

// How a member of ViewOptions is read and written. Whatever its type, a value is a double:
// enumerators and bool are the position of their name, from 0.
struct ParameterAccess {
  ParameterKind kind = ParameterKind::kNumber;
  double (*get)(const ViewOptions&) = nullptr;
  void (*set)(ViewOptions*, double) = nullptr;
};

template <auto member>
double get_member(const ViewOptions& options) {
  return static_cast<double>(options.*member);
}

template <auto member>
void set_member(ViewOptions* options, double value) {
  using Value = std::remove_cvref_t<decltype(options->*member)>;
  if constexpr (std::is_enum_v<Value>) {
    options->*member = static_cast<Value>(static_cast<int>(value));
  } else {
    options->*member = static_cast<Value>(value);
  }
}

template <typename Value>
constexpr ParameterKind parameter_kind(Value ViewOptions::* /*member*/) {
  if (std::is_floating_point_v<Value>) return ParameterKind::kNumber;
  return std::is_same_v<Value, int> ? ParameterKind::kInteger : ParameterKind::kChoice;
}

// The access to `member`, &ViewOptions::k_deg.
template <auto member>
inline constexpr ParameterAccess kAccess{parameter_kind(member), &get_member<member>,
                                         &set_member<member>};

struct ViewParameter {
  const char* key = nullptr;   // in settings files and JSON, with the unit as its suffix
  const char* flag = nullptr;  // "--overlap-deg"
  ParameterAccess value{};
  const char* unit = "";                 // for messages
  std::span<const char* const> names{};  // of a choice, in the order of its enumerators
  double least = 0.0;                    // of a number, both inclusive
  double most = 0.0;
  int multiple_of = 1;
  // How 0, which leaves the choice to the program and is the default then, is written; nullptr: 0
  // is a value like others. The renderer needs the number that the program chose.
  const char* zero = nullptr;
  const char* flag_sets = nullptr;  // of a flag without a value: what it sets
  ParameterGroup group = ParameterGroup::kView;
  const char* help = "";
  // Per output pixel. A sample is one position in a captured panorama, computed (some 25
  // operations) and read (4 pixels of 3 bytes, depending on `interpolation`).
  const char* cost = "";
  const char* phrase = "{}";  // the value as part of a setting's name
  // None: the same in all settings of a trade, which then do not record it.
  std::optional<ParameterSweep> sweep{};
};

// The value without flags: 0 where the program chooses, else that of ViewOptions.
double default_of(const ViewParameter& parameter);

// What is wrong with a value, "must be in 0..4 pixels"; none if nothing is. 0 is right where the
// parameter has a word for it.
std::optional<std::string> fault_of(const ViewParameter& parameter, double value);

// The values it takes, "auto or in 45..90 degrees".
std::string values_text(const ViewParameter& parameter);

// A value as it is written in settings files, flags and names, and back. Throws
// std::invalid_argument with the reason that the text is not a value of the parameter ("must be
// ...").
std::string text_of(const ViewParameter& parameter, double value);
double value_of(const ViewParameter& parameter, const std::string& text);

}  // namespace raywalk
