// How long the steps from frames to reports take: what the sizes of blocks follow from.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>

namespace raywalk::build_lf {

struct StepRate {
  std::string_view step{};     // as the step of a cluster plan is named
  double mpx_per_s = 0.0;      // that one thread does
  std::string_view counted{};  // which pixels
};

// Processor time of the programs on one machine of 2 cores, rounded down (docs/cluster.md,
// "Sizes of blocks", tells the runs). They are to be right within a factor of two or three: a block
// takes some minutes, not some seconds and not hours.
inline constexpr std::array kStepRates{
    StepRate{"pack", 45.0, "of all panoramas"},
    StepRate{"depth-links", 4.5, "of all panoramas"},
    StepRate{"depth-reach", 2.0, "of all distance maps"},
    StepRate{"depth-surfaces", 6.5, "of all distance maps"},
    StepRate{"depth-colours", 3.8, "of all distance maps"},
    StepRate{"depth-sweep", 0.14, "of all distance maps"},
    StepRate{"depth-choose", 0.25, "of all distance maps"},
    StepRate{"depth-fuse", 0.45, "of all distance maps"},
    StepRate{"depth-moved", 0.6, "of all distance maps"},
    StepRate{"depth-volumes", 20.0, "of all distance maps"},
    StepRate{"depth-gains", 0.7, "of all distance maps"},
    StepRate{"refine", 0.25, "of all developed stations"},
    StepRate{"connect-error", 13.0, "of the views of all cells, 49 x 49 each"},
    StepRate{"require", 3.5, "of all developed stations"},
    StepRate{"validate", 0.13, "of all true views"},
    StepRate{"path", 4.5, "of all views"},
    StepRate{"trade", 0.014, "of six true views"},
};

// Rates given by the user, by step; other steps have those of the table.
using GivenRates = std::map<std::string, double>;

// The rate of a step. Throws std::logic_error for a step that the table does not have.
double rate_of(std::string_view step, const GivenRates& given);

// "sweep=0.5,pack=100": rates as a command line gives them. Throws UsageError for a step that the
// table does not have or a rate that is not above 0.
GivenRates parse_rates(const std::string& text);

}  // namespace raywalk::build_lf
