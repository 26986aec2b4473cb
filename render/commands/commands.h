// The commands of raywalk-render. Each function adds one command with its options, an example and
// the callback that runs it.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::render {

// Making views.
void add_view(CLI::App* app);
void add_path(CLI::App* app);
void add_export_web(CLI::App* app);
void add_serve(CLI::App* app);
// Judging them.
void add_validate(CLI::App* app);
void add_connect_error(CLI::App* app);
void add_error_model(CLI::App* app);
void add_trade(CLI::App* app);

}  // namespace raywalk::render
