#pragma once
#include "app/frame_output.hpp"
#include "app/places.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "session/render_frames.hpp"

/// What all runs do that render a volume: open it, see that it fits into memory, load and render it.
namespace ringsplat::app {

/// All ranks call it; all throw the same InputError.
OpenedVolume open(const VolumeOptions& volume, Launch& launch);

/// Stands for a function that may need the histogram of a volume that is not loaded yet, where the rest of a
/// frame is checked.
TransferFunction stand_in_function();

SliceMemory predict_memory(const Grid& grid, const LoadOptions& load, SliceDealing dealing);

/// Chooses roles where that is left to the program, says how many Renderers get regions, and predicts what
/// the slices of so many `volumes` take. Throws InputError on all ranks when some process's slices, or its
/// frame buffer, which holds so many `pictures` at once, exceed the machine's memory.
SliceMemory settle_layout(RenderOptions& o, Layout& layout, const std::vector<Camera>& cameras,
                          const Grid& grid, const LoadOptions& load, std::size_t pictures,
                          const std::vector<Place>& places, Launch& launch, std::size_t volumes = 1);

/// Bytes that this process may hold of the next volume of a series while one is drawn: as many as it holds of
/// one volume's slices, or none where the machine has no room for so many beside slices and pictures.
std::size_t room_to_read_ahead(int width, int height, std::size_t pictures, const SliceMemory& slices,
                               const Layout& layout, const Launch& launch);

/// Deals an opened volume and closes it. Throws InputError when it has no finite value.
Scene load(OpenedVolume& volume, const LoadOptions& options, const Layout& layout, const Wiring& wiring,
           Progress& progress);

/// Renders all frames. Every input was checked on all ranks before, so an error here ends the job.
void render_all(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                const Wiring& wiring, const EngineOptions& engine);

/// For --verbose: this rank's role.
void log_roles(const Layout& layout, const SliceMemory& memory, const Launch& launch);

}  // namespace ringsplat::app
