// Reports as one self-contained HTML page: text, tables, plots and pictures, without scripts or
// other files (except what it links to). The page follows the reader's light or dark mode,
// prints well and is well-formed XML. Reports that show a JSON document are made with JsonPage
// (json_page.h).
//
//   HtmlPage page("Validation of room.lf", "12 views, hlf-vd at 16 layers");
//   page.add_section("Gain over distance");
//   page.add_paragraph("Each point is one view.");
//   page.add_figures({svg_figure(svg_from_plot(plot), "PSNR over distance from the line")});
//   write_file_atomically(dir / "index.html", page.html());
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/report/data_uri.h"

namespace raywalk {

// A figure and its caption. `markup` is inserted unescaped: use the functions below to make it.
struct HtmlFigure {
  std::string markup{};
  std::string caption{};  // plain text
};

// A figure of an <svg> element, e.g. from svg_from_plot.
HtmlFigure svg_figure(std::string svg, std::string caption);

// A figure of a picture, enlarged to its card's width where it is smaller. `alt` is its alternative
// text. Throws Error as data_uri does.
HtmlFigure picture_figure(const cv::Mat& image, EmbeddedFormat format, std::string_view alt,
                          std::string caption);

struct HtmlCell {
  std::string text{};       // plain text
  bool emphasised = false;  // bold and tinted, e.g. for the best value of a row
  std::string link{};       // target of the link; empty: none
};

// The first column names the row; the others are right-aligned, for numbers.
struct HtmlTable {
  std::string caption{};  // plain text, may be empty
  std::vector<std::string> header{};
  std::vector<std::vector<HtmlCell>> rows{};  // each as long as the header
};

// A figure of merit at the top of a report: "PSNR", "34.2 dB".
struct HtmlFact {
  std::string name{};
  std::string value{};
};

struct HtmlLink {
  std::string target{};
  std::string text{};
};

// An entry of a list of cards, with an anchor to link to.
struct HtmlCard {
  std::string anchor{};                        // link target "#anchor"; unique in the page
  std::string heading{};                       // plain text
  HtmlLink back{};                             // a link back; empty target: none
  std::string picture{};                       // markup, as picture_figure makes it; may be empty
  std::vector<std::vector<HtmlFact>> facts{};  // in groups
};

// All text is escaped. Content appears in the order it was added.
class HtmlPage {
 public:
  explicit HtmlPage(std::string_view title, std::string_view subtitle = {});

  // `anchor`: link target "#anchor".
  void add_section(std::string_view heading, std::string_view anchor = {});
  void add_paragraph(std::string_view text);
  // A section of its own.
  void add_warnings(std::span<const std::string> warnings);
  void add_facts(const std::vector<HtmlFact>& facts);
  // A table wider than the window scrolls by itself. Throws Error if a row is not as long as the
  // header.
  void add_table(const HtmlTable& table);
  // Side by side where the window has room, in as many columns as leave no gap, else one below the
  // other.
  void add_figures(const std::vector<HtmlFigure>& figures);

  // Side by side as far as the window has room; the card that a link targets is highlighted.
  void add_cards(std::span<const HtmlCard> cards);

  // The complete page so far.
  std::string html() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace raywalk
