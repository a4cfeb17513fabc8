#pragma once
#include <string>

namespace ringsplat {

/// A hash of the wire format, sixteen hexadecimal digits: builds with different digits misread each other's
/// messages. Covers the layouts of headers, payloads and reports, the order of kinds and choices, and the
/// fields of a FrameSpec, but not what nodes do with a message; the version stands for that.
std::string wire_format();

}  // namespace ringsplat
