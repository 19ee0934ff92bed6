#include <cstdio>
#include <sstream>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_sheet.hpp>

namespace frugal_nav {
namespace {

constexpr double kPrinterMargin_mm = 5.0;  // which printers leave white anyway, so that it counts as border
constexpr double kFooter_mm = 22.0;        // height of text and ruler, below the border
constexpr double kRuler_mm = 50.0;

std::string trimmed(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

void requireId(const MarkerDictionary& dictionary, int id) {
  if (id >= 0 && id < dictionary.count()) return;
  throw ConfigError(dictionary.name() + " has no id " + std::to_string(id) + ", only 0 to " +
                    std::to_string(dictionary.count() - 1));
}

/// The black cells, those in a row as one rectangle so that no seams show.
void drawCells(const cv::Mat& cells, double left_mm, double top_mm, double cell_mm, std::ostream& svg) {
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.cols; ++column) {
      if (cells.at<unsigned char>(row, column) != 0) continue;
      int end = column;
      while (end < cells.cols && cells.at<unsigned char>(row, end) == 0) ++end;
      svg << "  <rect x=\"" << left_mm + column * cell_mm << "\" y=\"" << top_mm + row * cell_mm
          << "\" width=\"" << (end - column) * cell_mm << "\" height=\"" << cell_mm << "\"/>\n";
      column = end;
    }
  }
}

void drawFooter(const std::string& text, const PaperSize& paper, double top_mm, std::ostream& svg) {
  const double middle_mm = 0.5 * paper.width_mm;
  const double ruler_left_mm = middle_mm - 0.5 * kRuler_mm;
  const auto label = [&](double y_mm, double size_mm, const std::string& line) {
    svg << "  <text x=\"" << middle_mm << "\" y=\"" << y_mm << "\" font-family=\"sans-serif\" font-size=\""
        << size_mm << "\" text-anchor=\"middle\">" << line << "</text>\n";
  };
  label(top_mm + 5.0, 4.5, text);
  svg << "  <rect x=\"" << ruler_left_mm << "\" y=\"" << top_mm + 11.0 << "\" width=\"" << kRuler_mm
      << "\" height=\"0.3\"/>\n";
  for (const double x_mm : {ruler_left_mm, ruler_left_mm + kRuler_mm - 0.3})
    svg << "  <rect x=\"" << x_mm << "\" y=\"" << top_mm + 9.5 << "\" width=\"0.3\" height=\"3.3\"/>\n";
  label(top_mm + 17.0, 3.5, trimmed(kRuler_mm) + " mm; print at 100 %, then measure");
}

}  // namespace

std::string markerSheet(const MarkerDictionary& dictionary, int id, double size_m, const PaperSize& paper) {
  requireId(dictionary, id);
  const double side_mm = 1000.0 * size_m;
  const double border_mm = kMarkerBorderShare * side_mm;
  const double needed_width_mm = side_mm + 2.0 * border_mm;
  if (!(side_mm > 0.0) || needed_width_mm > paper.width_mm ||
      needed_width_mm + kFooter_mm + kPrinterMargin_mm > paper.height_mm) {
    throw ConfigError("a marker of " + trimmed(side_mm) + " mm with its white border of " +
                      trimmed(border_mm) + " mm does not fit paper of " + trimmed(paper.width_mm) + " x " +
                      trimmed(paper.height_mm) + " mm");
  }
  const double left_mm = 0.5 * (paper.width_mm - side_mm);
  const double top_mm = 0.5 * (paper.height_mm - kFooter_mm - kPrinterMargin_mm - side_mm);
  std::ostringstream svg;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << paper.width_mm << "mm\" height=\""
      << paper.height_mm << "mm\" viewBox=\"0 0 " << paper.width_mm << ' ' << paper.height_mm
      << "\" shape-rendering=\"crispEdges\">\n"
      << "  <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  drawCells(dictionary.cellsOf(id), left_mm, top_mm, side_mm / dictionary.cells(), svg);
  drawFooter(dictionary.name() + "   id " + std::to_string(id) + "   side " + trimmed(side_mm) + " mm", paper,
             top_mm + side_mm + border_mm, svg);
  svg << "</svg>\n";
  return svg.str();
}

cv::Mat markerTexture(const MarkerDictionary& dictionary, int id, int cell_px) {
  requireId(dictionary, id);
  cv::Mat cells;
  cv::copyMakeBorder(dictionary.cellsOf(id), cells, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::Mat image;
  cv::resize(cells, image, cells.size() * cell_px, 0, 0, cv::INTER_NEAREST);
  return image;
}

double markerTextureSide_m(const MarkerDictionary& dictionary, double size_m) {
  return size_m * (dictionary.cells() + 2) / dictionary.cells();
}

}  // namespace frugal_nav
