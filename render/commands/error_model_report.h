// The work of `raywalk-render error-model`: the paper's Fig. 11 for a given cell as a report, JSON
// and a text table, compared with the values stated in the paper.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

namespace raywalk::render {

struct ErrorModelOptions {
  double side_m = 1.0;   // N, 0.01..1000
  double step_m = 0.01;  // between stations, 1e-5 N..N; not stated in the paper
  // d_src in multiples of N, 0.1..10000, in any order. Fig. 11 (a) is drawn at the middle one,
  // (b) at each, (c) over the range they span.
  std::vector<double> distances_over_side{1.2, 1.5, 2.5};
  int viewpoints = 49;                 // per side of the cell, 1..1000
  std::filesystem::path report_dir{};  // created if it is missing
};

// Writes index.html and error-model.json to report_dir, each atomically, and the table of optima as
// text to `table`. Takes about a second. error-model.json:
//   {"side_m", "step_m", "viewpoints", "k_deg": [45..90],
//    "detail": index of the curve of Fig. 11 (a),
//    "curves": [{"d_src_m", "d_src_over_side", "e_m_rad", "e_b_rad", "e_t", "optimum_k_deg",
//                "least_e_t", "paper_k_deg": null where the paper states none,
//                "given": whether it is one of distances_over_side}],
//    "paper": [{"d_src_over_side", "optimum_k_deg"}]}
// e_m_rad, e_b_rad and e_t have one entry for each k. Throws UsageError for an option outside its
// range, Error when a file cannot be written.
void write_error_model_report(const ErrorModelOptions& options, std::ostream& table);

}  // namespace raywalk::render
