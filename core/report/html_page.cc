#include "core/report/html_page.h"

#include <utility>

#include "core/base/error.h"
#include "core/report/markup.h"

namespace raywalk {
namespace {

constexpr std::string_view kStyle = R"(<style>
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1f2933; --soft: #5d6975;
  --rule: #dfe4e8; --panel: #f6f8f9; --accent: #0072b2; --best: #e2f1fa; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181c; --ink: #e4e8ec; --soft: #98a3af;
  --rule: #2d353d; --panel: #1b2126; --accent: #4aa8e0; --best: #17374a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
header { border-bottom: 2px solid var(--accent); margin-bottom: 1.5rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .6rem; }
p { max-width: 75ch; margin: .6rem 0; }
.subtitle { color: var(--soft); margin: 0 0 1rem; }
.facts { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.2rem 0; }
.facts div { background: var(--panel); border: 1px solid var(--rule); border-radius: 8px;
  padding: .6rem 1.1rem; }
.facts dt { color: var(--soft); font-size: .85rem; }
.facts dd { margin: 0; font-size: 1.35rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; margin: 1.2rem 0; }
table { border-collapse: collapse; font-size: .93rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--soft); padding-bottom: .4rem; }
th, td { padding: .35rem .9rem; text-align: right; border-bottom: 1px solid var(--rule);
  white-space: nowrap; }
th { font-weight: 600; }
thead th { border-bottom: 2px solid var(--rule); }
th:first-child { text-align: left; }
a { color: var(--accent); }
.best { background: var(--best); font-weight: 700; }
.figures { display: grid; gap: 1.4rem; margin: 1.2rem 0;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 480px), 1fr)); }
figure { margin: 0; background: var(--panel); border: 1px solid var(--rule); border-radius: 8px;
  padding: .8rem; break-inside: avoid; }
figure img { display: block; max-width: 100%; height: auto; margin: 0 auto; border-radius: 4px; }
figure svg { display: block; margin: 0 auto; }
figcaption { color: var(--soft); font-size: .9rem; padding-top: .6rem; }
</style>
)";

std::string element(std::string_view tag, std::string_view text) {
  const std::string name(tag);
  return "<" + name + ">" + escape_markup(text) + "</" + name + ">\n";
}

std::string table_cell(const HtmlCell& cell, bool names_row) {
  const std::string opening = names_row ? "<th scope=\"row\"" : "<td";
  return opening + (cell.emphasised ? " class=\"best\">" : ">") + escape_markup(cell.text) +
         (names_row ? "</th>" : "</td>");
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

void HtmlPage::add_section(std::string_view heading) { body_ += element("h2", heading); }

void HtmlPage::add_paragraph(std::string_view text) { body_ += element("p", text); }

void HtmlPage::add_facts(std::span<const HtmlFact> facts) {
  body_ += "<dl class=\"facts\">\n";
  for (const HtmlFact& fact : facts) {
    body_ += "<div>" + element("dt", fact.name) + element("dd", fact.value) + "</div>\n";
  }
  body_ += "</dl>\n";
}

void HtmlPage::add_facts(std::initializer_list<HtmlFact> facts) {
  add_facts(std::span<const HtmlFact>(facts.begin(), facts.size()));
}

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
  body_ += "<div class=\"scroll\">\n<table>\n";
  if (!table.caption.empty()) body_ += element("caption", table.caption);
  body_ += table_head(table.header) + "<tbody>\n" + rows + "</tbody>\n</table>\n</div>\n";
}

void HtmlPage::add_links(std::span<const HtmlLink> links) {
  body_ += "<ul>\n";
  for (const HtmlLink& link : links) {
    body_ +=
        "<li><a href=\"" + escape_markup(link.file) + "\">" + escape_markup(link.text) + "</a>";
    if (!link.note.empty()) body_ += ": " + escape_markup(link.note);
    body_ += "</li>\n";
  }
  body_ += "</ul>\n";
}

void HtmlPage::add_figures(std::span<const HtmlFigure> figures) {
  body_ += "<div class=\"figures\">\n";
  for (const HtmlFigure& figure : figures) {
    body_ += "<figure>\n" + figure.markup;
    if (!figure.caption.empty()) body_ += element("figcaption", figure.caption);
    body_ += "</figure>\n";
  }
  body_ += "</div>\n";
}

void HtmlPage::add_figures(std::initializer_list<HtmlFigure> figures) {
  add_figures(std::span<const HtmlFigure>(figures.begin(), figures.size()));
}

std::string HtmlPage::html() const {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>";
  page += title_;
  page += "</title>\n";
  page += kStyle;
  page += "</head>\n<body>\n<main>\n";
  page += body_;
  page += "</main>\n</body>\n</html>\n";
  return page;
}

}  // namespace raywalk
