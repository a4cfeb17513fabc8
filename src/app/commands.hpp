#pragma once
#include "options/options.hpp"
#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"
#include "session/render_frames.hpp"

/// One function a subcommand. All throw InputError and RunError.
namespace ringsplat::app {

/// All ranks call it.
ExitCode run_render(const RenderOptions& options, Launch& launch);
/// What these options need loaded when the views traverse `axes`.
LoadOptions load_options(const RenderOptions& options, std::array<bool, 3> axes);
/// All ranks call it.
ExitCode run_serve(const ServeOptions& options, Launch& launch);
// The others run on one process.
ExitCode run_info(const InfoOptions& options);
ExitCode run_synth(const SynthOptions& options);
ExitCode run_reference(const ReferenceOptions& options);

}  // namespace ringsplat::app
