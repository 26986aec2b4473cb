// How busy other programs keep the machine's processors.
#pragma once

#include <string>

namespace raywalk {

// Processor time since the machine started, seconds, summed over all processors.
struct ProcessorUse {
  double all_s = 0.0;   // idle or not
  double busy_s = 0.0;  // not idle, time stolen by other virtual machines included
  double own_s = 0.0;   // of this process, all threads
};

// The present use; all zero where the system does not tell.
ProcessorUse processor_use();

// From the text of /proc/stat (proc(5)).
ProcessorUse processor_use_from(const std::string& proc_stat, double own_s);

// The share of all processor time between two moments that other processes used, [0, 1]. The
// kernel counts in ticks of 10 ms on every processor; what these may hide is not counted, so a
// share of a time much shorter than half a second is 0.
double share_of_others(const ProcessorUse& before, const ProcessorUse& after);

}  // namespace raywalk
