#include "core/report/json_page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kLargest = "largest ";
constexpr std::string_view kLeast = "least ";

// Whether an expression has its largest (or least) value of several rows in `row`; numbers that are
// none do not count.
bool is_extreme(const std::vector<JsonScope>& rows, const JsonScope& row,
                std::string_view expression, bool largest) {
  const double own = row.number(expression);
  return rows.size() > 1 && std::isfinite(own) &&
         std::ranges::none_of(rows, [&](const JsonScope& other) {
           const double value = other.number(expression);
           return largest ? value > own : value < own;
         });
}

bool is_emphasised(const std::vector<JsonScope>& rows, const JsonScope& row,
                   std::string_view emphasis) {
  if (emphasis.empty()) return false;
  if (emphasis.starts_with(kLargest)) {
    return is_extreme(rows, row, emphasis.substr(kLargest.size()), true);
  }
  if (emphasis.starts_with(kLeast)) {
    return is_extreme(rows, row, emphasis.substr(kLeast.size()), false);
  }
  return row.holds(emphasis);
}

bool is_shown(const JsonScope& scope, std::string_view when) {
  return when.empty() || scope.holds(when);
}

void add_rows(const JsonScope& scope, const JsonRows& added, HtmlTable* table) {
  const std::vector<JsonScope> rows =
      added.list.empty() ? std::vector<JsonScope>{scope} : scope.entries(added.list);
  for (const JsonScope& row : rows) {
    std::vector<HtmlCell>& cells = table->rows.emplace_back();
    for (const JsonCell& cell : added.cells) {
      cells.push_back(
          {row.text(cell.text), is_emphasised(rows, row, cell.emphasis), row.text(cell.link)});
    }
  }
}

HtmlCard filled(const JsonScope& scope, const HtmlCard& card) {
  HtmlCard result{.anchor = scope.text(card.anchor),
                  .heading = scope.text(card.heading),
                  .back = {scope.text(card.back.target), scope.text(card.back.text)}};
  for (const std::vector<HtmlFact>& group : card.facts) {
    std::vector<HtmlFact>& facts = result.facts.emplace_back();
    for (const HtmlFact& fact : group) {
      facts.push_back({scope.text(fact.name), scope.text(fact.value)});
    }
  }
  return result;
}

PlotSeries& series_named(const std::string& name, PlotStyle style, LinePlot* plot) {
  const auto found = std::ranges::find(plot->series, name, &PlotSeries::name);
  if (found != plot->series.end()) return *found;
  return plot->series.emplace_back(PlotSeries{.name = name, .style = style});
}

}  // namespace

JsonPage::JsonPage(const Json& document, std::string_view title, std::string_view subtitle)
    : scope_(document) {
  page_ = std::make_shared<HtmlPage>(scope_.text(title), scope_.text(subtitle));
}

JsonPage JsonPage::part(JsonScope scope, bool shown) const {
  JsonPage part = *this;
  part.scope_ = std::move(scope);
  part.shown_ = shown_ && shown;
  return part;
}

JsonPage JsonPage::within(std::string_view path) const {
  return when(path).shown_ ? part(scope_.at(path), true) : part(scope_, false);
}

JsonPage JsonPage::when(std::string_view condition) const {
  return part(scope_, shown_ && scope_.holds(condition));
}

std::vector<JsonPage> JsonPage::parts(std::string_view list) const {
  std::vector<JsonPage> parts;
  if (!shown_) return parts;
  for (JsonScope& entry : scope_.entries(list)) parts.push_back(part(std::move(entry), true));
  return parts;
}

std::string JsonPage::text(std::string_view text) const { return shown_ ? scope_.text(text) : ""; }

JsonPage& JsonPage::section(std::string_view heading, std::string_view anchor) {
  if (shown_) page_->add_section(scope_.text(heading), anchor);
  return *this;
}

JsonPage& JsonPage::paragraph(std::string_view text) {
  if (shown_) page_->add_paragraph(scope_.text(text));
  return *this;
}

JsonPage& JsonPage::paragraphs(std::string_view list, std::string_view text) {
  for (JsonPage& entry : parts(list)) entry.paragraph(text);
  return *this;
}

JsonPage& JsonPage::warnings(std::string_view list) {
  std::vector<std::string> warnings;
  for (const JsonPage& entry : parts(list)) warnings.push_back(entry.text("{.}"));
  if (!warnings.empty()) page_->add_warnings(warnings);
  return *this;
}

JsonPage& JsonPage::facts(const std::vector<JsonFact>& facts) {
  if (!shown_) return *this;
  std::vector<HtmlFact> shown;
  for (const JsonFact& fact : facts) {
    if (!is_shown(scope_, fact.when)) continue;
    shown.push_back({scope_.text(fact.name), scope_.text(fact.value)});
  }
  if (!shown.empty()) page_->add_facts(shown);
  return *this;
}

JsonPage& JsonPage::table(std::string_view list, const std::vector<JsonColumn>& columns,
                          std::string_view caption) {
  JsonTable table{.caption = std::string(caption), .rows = {{.list = std::string(list)}}};
  for (const JsonColumn& column : columns) {
    table.header.push_back(column.header);
    table.rows[0].cells.push_back({column.cell, column.emphasis, column.link});
  }
  return this->table(table);
}

JsonPage& JsonPage::table(const JsonTable& table) {
  if (!shown_) return *this;
  HtmlTable filled{.caption = scope_.text(table.caption)};
  for (const std::string& header : table.header) filled.header.push_back(scope_.text(header));
  for (const JsonRows& rows : table.rows) {
    if (is_shown(scope_, rows.when)) add_rows(scope_, rows, &filled);
  }
  if (!filled.rows.empty()) page_->add_table(filled);
  return *this;
}

JsonPage& JsonPage::cards(std::string_view list, const HtmlCard& card,
                          const std::vector<std::string>& pictures) {
  std::vector<HtmlCard> cards;
  for (const JsonPage& entry : parts(list)) {
    cards.push_back(filled(entry.scope_, card));
    cards.back().picture = pictures.at(cards.size() - 1);
  }
  if (!cards.empty()) page_->add_cards(cards);
  return *this;
}

JsonPage& JsonPage::figures(std::vector<HtmlFigure> figures) {
  std::erase_if(figures, [](const HtmlFigure& figure) { return figure.markup.empty(); });
  if (shown_ && !figures.empty()) page_->add_figures(figures);
  return *this;
}

HtmlFigure JsonPage::plot(LinePlot axes, const std::vector<JsonSeries>& series,
                          std::string_view caption) const {
  if (!shown_) return {};
  for (std::string* label : {&axes.title, &axes.x_label, &axes.y_label}) *label = text(*label);
  for (const JsonSeries& each : series) {
    for (const JsonScope& entry : scope_.entries(each.list)) {
      series_named(entry.text(each.name), each.style, &axes)
          .points.push_back({entry.number(each.x), entry.number(each.y)});
    }
  }
  return svg_figure(svg_from_plot(axes), text(caption));
}

std::string JsonPage::html() const { return page_->html(); }

}  // namespace raywalk
