#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "classify/auto_preset.hpp"
#include "options/option_tables.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat::app {
namespace {

/// A number of nodes or slices, or "auto", which sets all of `choices`.
Reader count_or_auto(std::optional<int>& count, std::vector<bool*> choices) {
  return text([&count, choices = std::move(choices)](const std::string& word, const std::string& option) {
    if (word != "auto")
      count = read_number<int>(word, option);
    else
      for (bool* const choice : choices) *choice = true;
  });
}

ScalarType parse_type(const std::string& text, const std::string&) { return scalar_type_from(text); }

/// Of floating-point numbers with a fill value: voxels without data are not a number, so that nothing is
/// interpolated, summed or averaged with them.
class UnfilledSource final : public ForwardingSource {
 public:
  /// `notes`: the source's, without the fill value.
  UnfilledSource(std::unique_ptr<VolumeSource> source, VolumeNotes notes, double fill)
      : ForwardingSource(std::move(source), {}, std::move(notes)), fill_(fill) {}
  void read_slices(int first, int count, std::span<std::byte> out) override {
    ForwardingSource::read_slices(first, count, out);
    visit_type(grid().type, [&](auto zero) {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>) {
        auto* const values = reinterpret_cast<T*>(out.data());
        std::replace(values, values + out.size() / sizeof(T), T(fill_), std::numeric_limits<T>::quiet_NaN());
      }
    });
  }

 private:
  const double fill_;
};

}  // namespace

std::unique_ptr<VolumeSource> open_volume(const VolumeOptions& o) {
  auto volume = o.opener ? o.opener(o.choice) : ringsplat::open_volume(o.path, o.raw, o.choice);
  if (VolumeNotes notes = volume->notes(); notes.fill && !is_whole(volume->grid().type)) {
    const double fill = *std::exchange(notes.fill, std::nullopt);
    volume = std::make_unique<UnfilledSource>(std::move(volume), std::move(notes), fill);
  }
  if (o.mask.path.empty()) return volume;
  return segmented_source(std::move(volume), ringsplat::open_volume(o.mask.path), o.mask.labels,
                          o.mask.covered);
}

std::map<double, detail::LabelNotes> notes_of(const ShownLabels& mask) {
  std::map<double, detail::LabelNotes> notes;
  for (auto& [label, said] : detail::label_notes(mask.path))
    notes.try_emplace(label_byte(label), std::move(said));
  return notes;
}

std::vector<Tint> tints_of(const ShownLabels& mask, const std::vector<double>& labels) {
  std::vector<Tint> tints;
  if (mask.covered == Covered::alone) return tints;
  if (labels.empty())
    log_warning("{} covers nothing with the labels that --mask names", printable(mask.path));
  const auto notes = notes_of(mask);
  for (const double label : labels) {
    const auto of_file = notes.find(label);
    const bool own = of_file != notes.end() && of_file->second.colour;
    tints.push_back({int(label), srgb_to_linear(own ? *of_file->second.colour : label_colour(label)),
                     mask.covered == Covered::outlined ? 1.0F : 0.6F});
  }
  return tints;
}

void add_volume_options(OptionList& list, VolumeOptions& o) {
  list.below("Volume") += {
      {"volume", "VOLUME", nullptr,
       "NRRD, MetaImage, NIfTI, MGH, HDF5 (FILE:/DATASET), VTK, NumPy, MRC, FITS, TIFF or raw file, or a "
       "folder: Zarr, an AMReX plotfile, a DICOM series, TIFF or PNG files",
       value(o.path), Mark::of_program},
      {"--frame", "N", nullptr, "Of a file with several time points the one to take, from 0",
       value(o.choice.frame, {.least = 0})},
      {"--channel", "N|NAME,...|all", nullptr,
       "Of several values a voxel the one to take; a number from 0, r, g, b, a or the name of a channel or "
       "an array; render and serve also add up to six, each in its colour: 0,2 or DAPI=blue,GFP=#00ff00, or "
       "all",
       value(o.choice.channel)},
      {"--series", "NAME", nullptr, "Of a DICOM folder's series the one to take; ringsplat info lists them",
       value(o.choice.series)},
      {"--memory", "SIZE", "a third of the machine's",
       "Of an OME-Zarr pyramid the finest level is taken whose voxels take at most this: 8G, 500M",
       parsed(o.choice.memory, parse_memory)},
      {"--crop", "X0:X1,Y0:Y1,Z0:Z1", nullptr,
       "Read only these voxels, as if the file held no others; of a pyramid in voxels of the finest level; "
       "typed as --clip is, which hides voxels of the volume",
       parsed(o.choice.crop, parse_clip)},
      {"--mask", "FILE[=LABELS]", nullptr,
       "Show only what a segmentation covers, or of its labels some: seg.nrrd=1,3-5; of its own grid or "
       "another",
       parsed(o.mask, parse_mask)},
      {"--mask-as", nullptr, initial,
       "What --mask does: hide all else, or tint or outline what its labels cover, in the file's colours or "
       "usual ones",
       choice(o.mask.covered,
              {{"hide", Covered::alone}, {"tint", Covered::tinted}, {"outline", Covered::outlined}})},
  };
  list.below("Raw volumes (others describe themselves)") += {
      {"--dims", "XxYxZ", nullptr, "Voxels along x, y, z", parsed(o.raw.dims, parse_dims)},
      {"--type", "TYPE", nullptr, "int8 uint8 int16 uint16 int32 uint32 float32 float64",
       parsed(o.raw.type, parse_type)},
      {"--endian", nullptr, nullptr, "Byte order",
       choice(o.raw.big_endian, {{"little", false}, {"big", true}})},
      {"--offset", "BYTES", nullptr, "Bytes before the first voxel", value(o.raw.offset, {.least = 0})},
      {"--spacing", "XxYxZ", nullptr,
       "Distances between voxels; replaces the file's own, whatever the format",
       parsed(o.raw.spacing, parse_spacing)},
  };
}

void add_layout_options(OptionList& list, RunOptions& o) {
  list.below("Ranks") += {
      {"--gps", "G|auto", nullptr,
       "Ranks that hold slices and send what is visible; auto: as many as a frame is foreseen to need",
       count_or_auto(o.gps, {&o.choose_roles})},
      {"--renderers", "R|auto", nullptr,
       "Ranks that draw; what is left out follows from the launcher's count",
       count_or_auto(o.renderers, {&o.choose_roles})},
      {"--roles", nullptr, nullptr,
       "GPs and Renderers on ranks of their own, or GP p and Renderer p together on rank p",
       choice(o.placement, {{"dedicated", Placement::dedicated}, {"colocated", Placement::colocated}})},
      {"--bundle", "K|auto", nullptr,
       "So many consecutive slices are dealt to a GP together and travel under one token; without it 1, as "
       "in the paper; auto: as many as a described machine needs",
       count_or_auto(o.bundle, {&o.choose_roles, &o.choose_bundle})},
      {"--topology", nullptr, initial, "How the GPs are linked",
       choice(o.topology, {{"ring", Topology::ring}, {"mesh", Topology::mesh}})},
      {"--mesh", "COLUMNSxROWS", nullptr,
       "GPs of a mesh; it has a Renderer at the left end of every row unless --renderers says otherwise, at "
       "both ends up to twice as many",
       parsed(o.mesh, parse_mesh)},
      {"--routing", nullptr, initial,
       "In a mesh, messages go along a column and then a row, from neighbour to neighbour, or straight to "
       "their rank",
       choice(o.routing, {{"manhattan", Routing::manhattan}, {"direct", Routing::direct}})},
  };
}

void add_rank_options(OptionList& list, RunOptions& o) {
  list.below("Ranks") += {
      {"--threads-per-rank", "T", nullptr,
       "Threads that share a rank's work: its cores without it; ranks share their machine's cores evenly",
       value(o.threads_per_rank)},
      {"--transport", nullptr, initial,
       "MPI, or all nodes in this process; auto: MPI when a launcher started it",
       choice(o.transport, {{"auto", TransportChoice::automatic},
                            {"mpi", TransportChoice::mpi},
                            {"loopback", TransportChoice::loopback}}),
       Mark::of_program},
  };
}

void add_protocol_options(OptionList& list, RunOptions& o) {
  list.below("Protocol") += {
      {"--frames-in-flight", nullptr, initial, "Frames announced and not yet complete",
       value(o.protocol.frames_in_flight)},
      {"--slots", nullptr, nullptr,
       "Payloads a Renderer accepts before it has drawn them; without it 16 of sheets, 4 of splats and on "
       "described machines",
       value(o.protocol.slots)},
      {"--link-slots", nullptr, initial, "Messages of one buffer class that may be behind a mesh's link",
       value(o.protocol.link_slots)},
      {"--look-ahead", nullptr, nullptr,
       "Slices, or bundles of them, that a GP prepares before their tokens have passed; without it 4, all "
       "with --layers, and 1 of render with splats or a described machine",
       value(o.protocol.look_ahead)},
      {"--send-ahead", nullptr, nullptr,
       "Payloads that a token leaves behind before it waits until one is accepted; without it 16, but with "
       "splats or a described machine 0 of render, 4 of serve",
       value(o.protocol.send_ahead)},
      {"--keep", "MIB", nullptr,
       "Sheets: MiB of slices that a Renderer keeps, so that later frames need not send them again; without "
       "it its share of 2048, or of a quarter of all slices where that is more, at least 256; of one view "
       "none",
       value(o.engine.keep, {.least = 0})},
      {"--stall-timeout", "SECONDS", initial,
       "Seconds without any progress until it is said which rank is waited for",
       value(o.protocol.stall_timeout)},
      {"--stall-action", nullptr, initial, "What then comes of the run: it is given up, or waits on",
       choice(o.protocol.stall_ends, {{"end", true}, {"wait", false}})},
  };
}

void add_machine_options(OptionList& list, RunOptions& o) {
  list.below("Simulated machines (docs/simulation.md)") += {
      {"--machine", "FILE", nullptr, "Charge what this described machine's nodes would spend",
       value(o.machine)},
      {"--count-only", nullptr, nullptr,
       "Send payloads of the right size but draw nothing: for time and traffic, no picture",
       flag(o.simulation.count_only)},
      {"--voxel-weight", nullptr, initial,
       "With --count-only: so many voxels of its slice for which each voxel stands",
       value(o.simulation.voxel_weight, {1.0, 1e6})},
  };
}

void add_server_options(OptionList& list, ServeOptions& o) {
  list.below("Viewer") += {
      {"more", "VOLUME...", nullptr, "More volumes on the same grid, to be shown in its place or beside it",
       values(o.picture.more_volumes), Mark::of_program},
      {"--port", "N", initial, "Port of the page; 0: any that is free", value(o.port, {0, 65535})},
      {"--bind", "ADDRESS", initial, "Address to listen at; other machines reach others than 127.0.0.1",
       value(o.address)},
      {"--open", nullptr, nullptr, "Open the page in this machine's browser", flag(o.open)},
      {"--target-ms", "MS", initial, "Milliseconds that a picture may take while the volume is turned",
       value(o.target_ms, {1.0, 10000.0})},
      {"--coarse-above", "MIB", initial,
       "Show an eighth of the voxels while a volume of so much or more is loaded, where its format allows",
       value(o.coarse_above_mib, {0.0, 1e12})},
      {"--allow-host", "HOST:PORT", nullptr,
       "Another name under which a proxy or tunnel shows the page; may be given several times",
       values(o.allowed_hosts)},
      {"--allow-origin", "URL", nullptr,
       "Another origin whose pages may connect, as https://hub.example.org; may be given several times",
       values(o.allowed_origins)},
      {"--allow-frame", "URL", nullptr,
       "An origin whose pages may show the page in a frame, as http://localhost:* for notebooks; may be "
       "given several times",
       values(o.allowed_frames)},
      {"--background", "COLOUR", "black", "A name, #rrggbb or r,g,b from 0 to 1",
       parsed(o.picture.background, parse_colour)},
  };
}

void add_info_options(OptionList& list, InfoOptions& o) {
  list.below("Output") += {
      {"--gps", "G", nullptr, "Predict the memory of a GP for G of them", value(o.gps, {1, 1 << 24})},
      {"--bundle", "K", initial, "Predict for bundles of so many slices",
       value(o.bundle, {1, most_slices_of_bundle})},
      {"--json", nullptr, nullptr, "Write JSON", flag(o.json)},
      {"--presets", nullptr, nullptr, "List the transfer functions that --tf knows by name", flag(o.presets)},
  };
  list.below("Prediction") += {
      {"--ranks", "N", nullptr, "Predict a frame's time for all ways to give N ranks roles",
       value(o.ranks, {1, 4096})},
      {"--cores", "C", nullptr, "Cores that the ranks share; without it this machine's",
       value(o.cores, {1, 1 << 24})},
      {"--machine", "FILE", nullptr,
       "Predict for a described machine (docs/simulation.md) instead of this one", value(o.machine)},
  };
}

void add_compare_options(OptionList& list, CompareOptions& o) {
  list.below("Output") += {
      {"a", "A", nullptr, "The picture in question", value(o.a), Mark::required},
      {"b", "B", nullptr, "What it is compared with", value(o.b), Mark::required},
      {"--threshold", nullptr, initial, "Count the pixels that differ by more than this, in 1/255",
       value(o.threshold, {.least = 0})},
      {"--fail-above", nullptr, nullptr, "Exit with 1 when the RMSE is above this, in 1/255",
       value(o.fail_above, {.least = 0})},
      {"--diff", "FILE", nullptr, "Write the difference: absolute, in an .exr signed", value(o.difference)},
      {"--diff-scale", nullptr, initial, "Multiply the written difference",
       value(o.difference_scale, {-1e12, 1e12})},
      {"--json", nullptr, nullptr, "Write JSON", flag(o.json)},
  };
}

void add_pyramid_options(OptionList& list, PyramidOptions& o) {
  list.below("Output") += {
      {"store", "OUT.zarr", nullptr,
       "The folder to make; one that was begun for the same volume is gone on with", value(o.output),
       Mark::required},
      {"--labels", nullptr, nullptr,
       "Take every second voxel, whatever the file says of its values, instead of mixing them",
       flag(o.labels)},
  };
}

void add_synth_options(OptionList& list, SynthOptions& o) {
  list.below("Output") += {
      {"name", "NAME", nullptr, "Which volume; --list says what there is", value(o.name)},
      {"-o,--output", "FILE", nullptr,
       ".nrrd, .nhdr, .mhd or .raw (dimensions and type then go into its name)", value(o.output)},
      {"--dims", "XxYxZ", "64x64x64", "Voxels along x, y, z", parsed(o.dims, parse_dims)},
      {"--type", "TYPE", "uint8", "int8 uint8 int16 uint16 int32 uint32 float32 float64",
       parsed(o.type, parse_type)},
      {"--spacing", "XxYxZ", "1x1x1", "Distances between voxels", parsed(o.spacing, parse_spacing)},
      {"--no-compression", nullptr, nullptr,
       "Write a .nrrd without gzip, so that all ranks can read it at once", flag(o.no_compression)},
      {"--list", nullptr, nullptr, "List the volumes", flag(o.list)},
  };
}

}  // namespace ringsplat::app
