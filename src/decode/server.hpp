#pragma once

namespace ringsplat::decode {

/// Answers the requests of the process that started this program, until that has ended.
void serve();

}  // namespace ringsplat::decode
