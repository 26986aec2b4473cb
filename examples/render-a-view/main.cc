// render-a-view ROOM X Z PICTURE: renders the panorama that is seen from a point of a room (metres,
// in the frame of its poses.csv) and writes it as PNG or JPEG.
#include <exception>
#include <iostream>
#include <string>

#include "core/files/image_file.h"
#include "core/geometry/grid.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "core/view/view_options.h"

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: render-a-view ROOM X Z PICTURE\n";
    return 2;
  }
  try {
    const raywalk::Room room = raywalk::Room::open(argv[1]);
    raywalk::ViewOptions options;
    options.method = raywalk::ViewMethod::kTwoSided;
    options.width = raywalk::size_as_captured(room).width;
    raywalk::Renderer renderer(room, options);
    const raywalk::RenderedView view = renderer.render({std::stod(argv[2]), std::stod(argv[3])});
    raywalk::write_image(argv[4], view.image);
    std::cout << argv[4] << ": " << view.image.cols << " x " << view.image.rows << " pixels in "
              << view.report.render_ms << " ms\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "render-a-view: " << e.what() << '\n';
    return 1;
  }
}
