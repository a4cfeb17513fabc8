#pragma once
#include <vector>

#include "net/message.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// Throws RunError, naming the sender, when a header names nodes that the layout does not have.
void check(const Header& header, const Layout& layout);

/// The ranks to which `rank` passes an announcement that starts at rank 0 (binomial tree).
std::vector<int> announcement_children(int rank, int ranks);

}  // namespace ringsplat
