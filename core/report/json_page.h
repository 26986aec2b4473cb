// Reports made from the JSON documents that are written beside them: a page says what is shown and
// where; all figures come from the document, whose numbers it formats once.
//
//   JsonPage page(document, "Poses of {source}", "{lines:counted line}, {stations} stations");
//   page.facts({{"stations with a pose", "{posed} of {stations}"},
//               {"residual", "{residual_px:.2f px}"},
//               {"held-out frames", "{held_out.frames}", "held_out"}});  // only if there are any
//   page.warnings("warnings");
//   page.section("Lines").table("lines", {{"line", "{id}"},
//                                         {"residual / px", "{residual_px:.2f}"},
//                                         {"model", "{model}", "!trustworthy"}});  // emphasised if
//   page.when("crossings").section("Crossings").paragraph("{crossings:size} places.");
//   JsonPage truth = page.within("truth");  // null: nothing of what follows is added
//   truth.section("Comparison").paragraph("{within_1px_share:.1%} of {/room}.");
//   page.figures({page.plot({.x_label = "station", .y_label = "confidence"},
//                           {{"maps", "{line}", "station", "mean_confidence"}}, "Of each map")});
//   write_file_atomically(dir / "poses.html", page.html());
//
// All texts are templates, filled as JsonScope::text does (json_scope.h has paths, conditions and
// placeholders, json_format.h the formats). So no text of the code's own may contain what a user
// chose, e.g. the name of a file: put it into the document. What does not fit the document throws
// std::logic_error.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/report/html_page.h"
#include "core/report/json_scope.h"
#include "core/report/svg_plot.h"

namespace raywalk {

struct JsonFact {
  std::string name{};
  std::string value{};
  std::string when{};  // the condition to show it; empty: always
};

// A cell of a table.
struct JsonCell {
  std::string text{};
  // The condition to emphasise it, or "largest EXPRESSION" or "least EXPRESSION" over the rows, if
  // there are several.
  std::string emphasis{};
  std::string link{};  // target; empty: none
};

// A column of a table with a row for each entry of a list.
struct JsonColumn {
  std::string header{};
  std::string cell{};
  std::string emphasis{};  // as in JsonCell
  std::string link{};
};

// A row for each entry of the list; `list` empty: a single row.
struct JsonRows {
  std::string list{};
  std::vector<JsonCell> cells{};
  std::string when{};  // as in JsonFact
};

// A table whose rows are not all of one list.
struct JsonTable {
  std::string caption{};
  std::vector<std::string> header{};
  std::vector<JsonRows> rows{};
};

// A point of a plot for each entry of a list.
struct JsonSeries {
  std::string list{};
  std::string name{};  // entries whose filled names differ are series of their own
  std::string x{};     // expressions
  std::string y{};
  PlotStyle style = PlotStyle::kLineAndPoints;
};

// A page, or a part of one.
class JsonPage {
 public:
  // `document` has to outlive the page.
  JsonPage(const nlohmann::ordered_json& document, std::string_view title,
           std::string_view subtitle = {});

  // The same page, with paths that start at a part of the document. Adds nothing if the part is
  // null, false, zero or empty.
  JsonPage within(std::string_view path) const;
  // The same page; adds nothing unless the condition holds.
  JsonPage when(std::string_view condition) const;
  // within() each entry of a list.
  std::vector<JsonPage> parts(std::string_view list) const;

  // A text of its own, e.g. a figure's caption.
  std::string text(std::string_view text) const;

  JsonPage& section(std::string_view heading, std::string_view anchor = {});
  JsonPage& paragraph(std::string_view text);
  // A paragraph for each entry of a list.
  JsonPage& paragraphs(std::string_view list, std::string_view text = "{.}");
  // The texts of a list, emphasised under a heading of their own; nothing if there are none.
  JsonPage& warnings(std::string_view list);
  JsonPage& facts(const std::vector<JsonFact>& facts);
  // Nothing if there are no rows.
  JsonPage& table(std::string_view list, const std::vector<JsonColumn>& columns,
                  std::string_view caption = {});
  JsonPage& table(const JsonTable& table);
  // A card for each entry of a list. `pictures`: markup of each; may be empty.
  JsonPage& cards(std::string_view list, const HtmlCard& card,
                  const std::vector<std::string>& pictures);
  // Figures without markup are left out. Captions are shown as they are.
  JsonPage& figures(std::vector<HtmlFigure> figures);

  // A plot of the document's lists. `axes`: all but the series. Without markup where this part adds
  // nothing.
  HtmlFigure plot(LinePlot axes, const std::vector<JsonSeries>& series,
                  std::string_view caption) const;

  std::string html() const;

 private:
  JsonPage part(JsonScope scope, bool shown) const;

  std::shared_ptr<HtmlPage> page_;
  JsonScope scope_;
  bool shown_ = true;
};

}  // namespace raywalk
