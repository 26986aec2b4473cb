#include "core/report/html_page.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/report/markup.h"

namespace raywalk {
namespace {

constexpr std::string_view kPageStyle = R"(<style>
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1f2933; --soft: #5d6975;
  --rule: #dfe4e8; --panel: #f6f8f9; --accent: #0072b2; --best: #e2f1fa;
  --warning: #d55e00; }
/* Paper is white: what is printed is light also where the reader prefers dark pages. */
@media screen and (prefers-color-scheme: dark) { :root { --paper: #14181c; --ink: #e4e8ec;
  --soft: #98a3af; --rule: #2d353d; --panel: #1b2126; --accent: #4aa8e0; --best: #17374a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
header { border-bottom: 2px solid var(--accent); margin-bottom: 1.5rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h1, h2, p, li, dd, figcaption { overflow-wrap: anywhere; }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .6rem; }
p { max-width: 75ch; margin: .6rem 0; }
.subtitle { color: var(--soft); margin: 0 0 1rem; }
.warnings { border: 1px solid var(--rule); border-left: 4px solid var(--warning); border-radius: 8px;
  background: var(--panel); padding: .6rem 1.1rem; margin: 1.2rem 0; }
.warnings h2 { font-size: 1rem; margin: 0; }
.facts { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.2rem 0; }
.facts div { background: var(--panel); border: 1px solid var(--rule); border-radius: 8px;
  padding: .6rem 1.1rem; }
.facts dt { color: var(--soft); font-size: .85rem; }
.facts dd { margin: 0; font-size: 1.35rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.table { margin: 1.2rem 0; }
.table p { color: var(--soft); font-size: .93rem; margin: 0 0 .4rem; }
table { border-collapse: collapse; font-size: .93rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .55rem; text-align: right; border-bottom: 1px solid var(--rule);
  white-space: nowrap; }
th { font-weight: 600; }
thead th { border-bottom: 2px solid var(--rule); vertical-align: bottom; white-space: normal; }
th:first-child { text-align: left; }
tbody th { white-space: normal; min-width: 9rem; }
a { color: var(--accent); }
.best { background: var(--best); font-weight: 700; }
.figures { display: grid; gap: 1.4rem; margin: 1.2rem 0; grid-template-columns: minmax(0, 1fr); }
figure { margin: 0; border: 1px solid var(--rule); border-radius: 8px; padding: .8rem; }
/* Small pictures fill their card; one that has the page to itself keeps its size or is enlarged a
   little. */
figure img { display: block; width: 100%; height: auto; margin: 0 auto; border-radius: 4px; }
.one > figure img, .two > figure:last-child:nth-child(odd) img { width: auto; max-width: 100%;
  min-width: min(100%, 720px); }
figure > svg { display: block; margin: 0 auto; max-width: 100%; height: auto; }
.cards { display: grid; gap: 1.4rem; margin: 1.2rem 0; align-items: start;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 480px), 1fr)); }
.card { background: var(--panel); border: 1px solid var(--rule); border-radius: 8px;
  padding: .8rem 1rem; scroll-margin-top: 1rem; }
.card:target { border-color: var(--accent); box-shadow: 0 0 0 2px var(--accent); }
.card h3 { display: flex; justify-content: space-between; gap: 1rem; font-size: 1rem;
  margin: 0 0 .6rem; }
.card h3 a { font-weight: 400; white-space: nowrap; }
.card img { display: block; width: 100%; height: auto; border-radius: 4px; }
.values { columns: 2; column-gap: 1.6rem; margin: .7rem 0 0; font-size: .88rem;
  border-top: 1px solid var(--rule); padding-top: .5rem; }
.values div { display: flex; justify-content: space-between; gap: .8rem; break-inside: avoid; }
.values dt { color: var(--soft); }
.values dd { margin: 0; font-variant-numeric: tabular-nums; text-align: right; }
figcaption { color: var(--soft); font-size: .9rem; padding-top: .6rem; }
@media print, (min-width: 1060px) {
.two { grid-template-columns: repeat(2, minmax(0, 1fr)); }
.two > figure:last-child:nth-child(odd) { grid-column: 1 / -1; } }
@media print, (min-width: 900px) {
.three { grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .9rem; } }
@media screen {
/* A wide table scrolls by itself, a drawing in its card; a shadow at an edge shows that there is
   more. */
.scroll, figure { overflow-x: auto; --under: var(--paper); background:
  linear-gradient(to right, var(--under) 40%, transparent) left / 2.5rem 100% no-repeat local,
  linear-gradient(to left, var(--under) 40%, transparent) right / 2.5rem 100% no-repeat local,
  linear-gradient(to right, #0004, transparent) left / .8rem 100% no-repeat,
  linear-gradient(to left, #0004, transparent) right / .8rem 100% no-repeat var(--under); }
figure { --under: var(--panel); } }
/* A phone: smaller margins, and names of rows that stay while their table scrolls. */
@media screen and (max-width: 600px) {
main { padding: 1.5rem 1rem 3rem; }
h1 { font-size: 1.5rem; }
h2 { font-size: 1.2rem; margin-top: 2rem; }
.facts { display: grid; grid-template-columns: 1fr 1fr; gap: .5rem; }
.facts div { padding: .5rem .7rem; }
.facts div:last-child:nth-child(odd) { grid-column: 1 / -1; }
.facts dd { font-size: 1.1rem; line-height: 1.35; }
figure { padding: .6rem; }
.values { columns: 1; }
table { font-size: .86rem; }
th, td { padding: .35rem .45rem; }
tbody th { min-width: 7.5rem; }
th:first-child { position: sticky; left: 0; }
th:first-child:not(.best) { background: var(--paper); } }
@media print {
@page { margin: 14mm; }
:root { font-size: 10pt; }
body { font-size: 1rem; line-height: 1.45; }
main { max-width: none; padding: 0; }
h1 { font-size: 1.6rem; }
h2 { margin-top: 1.6rem; }
h1, h2, h3, .table > p { break-after: avoid; }
p { orphans: 3; widows: 3; }
.facts, .figures, .cards { gap: .7rem; }
.facts div { padding: .3rem .7rem; }
.facts dd { font-size: 1.1rem; }
/* Nothing scrolls on paper: cells break their lines where a table would be too wide. */
table { font-size: .88rem; }
table:has(th:nth-child(10)) { font-size: .75rem; }
th, td { white-space: normal; padding: .2rem .45rem; }
tbody th { min-width: 0; }
tr, figure, .card, .facts div, .warnings { break-inside: avoid; }
/* Short tables stay whole; of others, no row is left alone at an end of a page. */
.table:not(:has(tr:nth-child(16))) { break-inside: avoid; }
tbody tr:nth-child(-n+2) { break-after: avoid; }
tbody tr:nth-last-child(-n+2) { break-before: avoid; }
figure { padding: .5rem; }
figure > svg { min-width: 0 !important; }
.cards { grid-template-columns: repeat(2, minmax(0, 1fr)); } }
</style>
)";

std::string element(std::string_view tag, std::string_view text) {
  const std::string name(tag);
  return "<" + name + ">" + escape_markup(text) + "</" + name + ">\n";
}

std::string link_element(const std::string& target, const std::string& text) {
  return "<a href=\"" + escape_markup(target) + "\">" + escape_markup(text) + "</a>";
}

std::string table_cell(const HtmlCell& cell, bool names_row) {
  const std::string opening = names_row ? "<th scope=\"row\"" : "<td";
  const std::string text =
      cell.link.empty() ? escape_markup(cell.text) : link_element(cell.link, cell.text);
  return opening + (cell.emphasised ? " class=\"best\">" : ">") + text +
         (names_row ? "</th>" : "</td>");
}

// A list of names and values.
std::string fact_list(std::span<const HtmlFact> facts, std::string_view css_class) {
  std::string markup = "<dl class=\"" + std::string(css_class) + "\">\n";
  for (const HtmlFact& fact : facts) {
    markup += "<div>" + element("dt", fact.name) + element("dd", fact.value) + "</div>\n";
  }
  return markup + "</dl>\n";
}

std::string card_element(const HtmlCard& card) {
  std::string markup = "<section class=\"card\" id=\"" + escape_markup(card.anchor) + "\">\n<h3>" +
                       element("span", card.heading);
  if (!card.back.target.empty()) markup += link_element(card.back.target, card.back.text);
  markup += "</h3>\n" + card.picture;
  for (const std::vector<HtmlFact>& group : card.facts) markup += fact_list(group, "values");
  return markup + "</section>\n";
}

std::string table_row(const std::vector<HtmlCell>& row) {
  std::string markup = "<tr>";
  for (std::size_t i = 0; i < row.size(); ++i) markup += table_cell(row[i], i == 0);
  return markup + "</tr>\n";
}

std::string table_head(const std::vector<std::string>& header) {
  std::string markup = "<thead><tr>";
  for (const std::string& name : header) {
    markup += "<th scope=\"col\">" + escape_markup(name) + "</th>";
  }
  return markup + "</tr></thead>\n";
}

// As many columns as leave no gap; drawings need the width of half a page. Where the last figure of
// two columns is alone, the style gives it the whole width.
std::string_view columns_of(std::span<const HtmlFigure> figures) {
  const bool pictures = std::all_of(figures.begin(), figures.end(), [](const HtmlFigure& figure) {
    return figure.markup.starts_with("<img");
  });
  if (figures.size() == 1) return "one";
  return pictures && figures.size() % 2 == 1 && figures.size() % 3 == 0 ? "three" : "two";
}

}  // namespace

HtmlFigure svg_figure(std::string svg, std::string caption) {
  return {std::move(svg), std::move(caption)};
}

HtmlFigure picture_figure(const cv::Mat& image, EmbeddedFormat format, std::string_view alt,
                          std::string caption) {
  return {"<img src=\"" + data_uri(image, format) + "\" width=\"" + std::to_string(image.cols) +
              "\" height=\"" + std::to_string(image.rows) + "\" alt=\"" + escape_markup(alt) +
              "\"/>\n",
          std::move(caption)};
}

HtmlPage::HtmlPage(std::string_view title, std::string_view subtitle)
    : title_(escape_markup(title)) {
  body_ = "<header>\n<h1>" + title_ + "</h1>\n";
  if (!subtitle.empty()) body_ += "<p class=\"subtitle\">" + escape_markup(subtitle) + "</p>\n";
  body_ += "</header>\n";
}

void HtmlPage::add_section(std::string_view heading, std::string_view anchor) {
  if (anchor.empty()) {
    body_ += element("h2", heading);
  } else {
    body_ += "<h2 id=\"" + escape_markup(anchor) + "\">" + escape_markup(heading) + "</h2>\n";
  }
}

void HtmlPage::add_paragraph(std::string_view text) { body_ += element("p", text); }

void HtmlPage::add_warnings(std::span<const std::string> warnings) {
  body_ += "<section class=\"warnings\">\n" + element("h2", "Warnings");
  for (const std::string& warning : warnings) add_paragraph(warning);
  body_ += "</section>\n";
}

void HtmlPage::add_facts(const std::vector<HtmlFact>& facts) { body_ += fact_list(facts, "facts"); }

void HtmlPage::add_table(const HtmlTable& table) {
  std::string rows;
  for (const std::vector<HtmlCell>& row : table.rows) {
    if (row.size() != table.header.size()) {
      throw Error("report: table '" + table.caption + "' has a row of " +
                  std::to_string(row.size()) + " cells under a header of " +
                  std::to_string(table.header.size()));
    }
    rows += table_row(row);
  }
  // The caption stands beside what scrolls, so that it is as wide as the page and not as the table.
  body_ += "<div class=\"table\">\n";
  if (!table.caption.empty()) body_ += element("p", table.caption);
  const std::string label = table.caption.empty() ? "table" : escape_markup(table.caption);
  body_ += "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"" + label +
           "\">\n<table>\n" + table_head(table.header) + "<tbody>\n" + rows +
           "</tbody>\n</table>\n</div>\n</div>\n";
}

void HtmlPage::add_figures(const std::vector<HtmlFigure>& figures) {
  body_ += "<div class=\"figures " + std::string(columns_of(figures)) + "\">\n";
  for (const HtmlFigure& figure : figures) {
    body_ += "<figure>\n" + figure.markup;
    if (!figure.caption.empty()) body_ += element("figcaption", figure.caption);
    body_ += "</figure>\n";
  }
  body_ += "</div>\n";
}

void HtmlPage::add_cards(std::span<const HtmlCard> cards) {
  body_ += "<div class=\"cards\">\n";
  for (const HtmlCard& card : cards) body_ += card_element(card);
  body_ += "</div>\n";
}

std::string HtmlPage::html() const {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>";
  page += title_;
  page += "</title>\n";
  page += kPageStyle;
  page += "</head>\n<body>\n<main>\n";
  page += body_;
  page += "</main>\n</body>\n</html>\n";
  return page;
}

}  // namespace raywalk
