#include "options/option_tables.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

using Serve = ServeOptions;

constexpr OptionRow<Serve> server_rows[] = {
    {"--port", "N", initial, "Port of the page; 0: any that is free",
     [](Serve& o) {
       return value(o.port, {0, 65535});
     }},
    {"--bind", "ADDRESS", initial, "Address to listen at; other machines reach others than 127.0.0.1",
     [](Serve& o) { return value(o.address); }},
    {"--open", nullptr, nullptr, "Open the page in this machine's browser",
     [](Serve& o) { return flag(o.open); }},
    {"--target-ms", "MS", initial, "Milliseconds that a picture may take while the volume is turned",
     [](Serve& o) {
       return value(o.target_ms, {1.0, 10000.0});
     }},
    {"--allow-host", "HOST:PORT", nullptr,
     "Another name under which a proxy or tunnel shows the page; may be given several times",
     [](Serve& o) { return values(o.allowed_hosts); }},
    {"--allow-origin", "URL", nullptr,
     "Another origin whose pages may connect, as https://hub.example.org; may be given several times",
     [](Serve& o) { return values(o.allowed_origins); }},
    {"--allow-frame", "URL", nullptr,
     "An origin whose pages may show the page in a frame, as http://localhost:* for notebooks; may be given "
     "several "
     "times",
     [](Serve& o) { return values(o.allowed_frames); }},
    {"--background", "COLOUR", "black", "A name, #rrggbb or r,g,b from 0 to 1",
     [](Serve& o) { return parsed(o.picture.background, parse_colour); }},
};

}  // namespace

constexpr OptionGroup<Serve> server_options{"Viewer", server_rows};

}  // namespace ringsplat::app
