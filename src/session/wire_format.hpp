#pragma once
#include <string>

namespace ringsplat {

/// Sixteen hexadecimal digits that are others when ranks of another build would take messages for something
/// else: the layouts of headers, payloads and reports, the order of kinds and choices, and the bytes of a
/// FrameSpec are hashed. It knows nothing of what nodes do with a message; the version says that.
std::string wire_format();

}  // namespace ringsplat
