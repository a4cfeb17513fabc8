#pragma once
#include <memory>

#include "protocol/engine.hpp"

namespace ringsplat {

/// An engine whose steps are bundles: up to `bundle` consecutive slices, all of one GP, which are the steps
/// of `inner`. A Renderer's payloads of a bundle's slices are joined to one, so that a token passes the
/// bundle as it passes a slice, by payload, accept and token. Bundles are those of the volume: where a frame
/// shows a part of it, its first and its last bundle may be shorter. Painters draw slice by slice, so no bit
/// depends on `bundle`.
std::unique_ptr<Engine> make_bundle_engine(std::unique_ptr<Engine> inner, int bundle);

}  // namespace ringsplat
