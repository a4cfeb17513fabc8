#include "options/option_tables.hpp"

#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// A number of nodes, or "auto", which sets `choose`.
Reader count_or_auto(std::optional<int>& count, bool& choose) {
  return text([&count, &choose](const std::string& word, const std::string& option) {
    if (word == "auto")
      choose = true;
    else
      count = parse_count(word, option);
  });
}

/// A number of slices, or "auto", which is chosen together with the roles.
Reader bundle_or_auto(RunOptions& run) {
  return text([&run](const std::string& word, const std::string& option) {
    if (word == "auto")
      run.choose_roles = run.choose_bundle = true;
    else
      run.bundle = parse_count(word, option);
  });
}

ScalarType parse_type(const std::string& text, const std::string&) { return scalar_type_from(text); }

using Volume = VolumeOptions;
constexpr OptionRow<Volume> volume_rows[] = {
    {"volume", "VOLUME", nullptr,
     "NRRD, MetaImage, NIfTI, HDF5 (FILE:/DATASET), VTK, NumPy, TIFF or raw file, or a folder with a DICOM "
     "series or TIFF pages",
     [](Volume& o) { return value(o.path); }, Mark::of_program},
    {"--frame", "N", nullptr, "Of a file with several time points the one to take, from 0",
     [](Volume& o) { return value(o.choice.frame, {.least = 0}); }},
    {"--channel", "N|NAME", nullptr,
     "Of several values a voxel the one to take; a number from 0, r, g, b, a or an array's name",
     [](Volume& o) { return value(o.choice.channel); }},
    {"--series", "NAME", nullptr, "Of a DICOM folder's series the one to take; ringsplat info lists them",
     [](Volume& o) { return value(o.choice.series); }},
};

constexpr OptionRow<Volume> raw_rows[] = {
    {"--dims", "XxYxZ", nullptr, "Voxels along x, y, z",
     [](Volume& o) { return parsed(o.raw.dims, parse_dims); }},
    {"--type", "TYPE", nullptr, "int8 uint8 int16 uint16 int32 uint32 float32 float64",
     [](Volume& o) { return parsed(o.raw.type, parse_type); }},
    {"--endian", nullptr, nullptr, "Byte order",
     [](Volume& o) {
       return choice(o.raw.big_endian, {{"little", false}, {"big", true}});
     }},
    {"--offset", "BYTES", nullptr, "Bytes before the first voxel",
     [](Volume& o) { return value(o.raw.offset, {.least = 0}); }},
    {"--spacing", "XxYxZ", nullptr, "Distances between voxels; replaces the file's own, whatever the format",
     [](Volume& o) { return parsed(o.raw.spacing, parse_spacing); }},
};

using Run = RunOptions;
constexpr OptionRow<Run> layout_rows[] = {
    {"--gps", "G|auto", nullptr,
     "Ranks that hold slices and send what is visible; auto: as many as a frame is foreseen to need",
     [](Run& o) { return count_or_auto(o.gps, o.choose_roles); }},
    {"--renderers", "R|auto", nullptr, "Ranks that draw; what is left out follows from the launcher's count",
     [](Run& o) { return count_or_auto(o.renderers, o.choose_roles); }},
    {"--roles", nullptr, nullptr,
     "GPs and Renderers on ranks of their own, or GP p and Renderer p together on rank p",
     [](Run& o) {
       return choice(o.placement, {{"dedicated", Placement::dedicated}, {"colocated", Placement::colocated}});
     }},
    {"--bundle", "K|auto", nullptr,
     "So many consecutive slices are dealt to a GP together and travel under one token; without it 1, as in "
     "the paper; auto: as many as a described machine needs",
     [](Run& o) { return bundle_or_auto(o); }},
    {"--topology", nullptr, initial, "How the GPs are linked",
     [](Run& o) {
       return choice(o.topology, {{"ring", Topology::ring}, {"mesh", Topology::mesh}});
     }},
    {"--mesh", "COLUMNSxROWS", nullptr,
     "GPs of a mesh; it has a Renderer at the left end of every row unless --renderers says otherwise, at "
     "both ends up to twice as many",
     [](Run& o) { return parsed(o.mesh, parse_mesh); }},
    {"--routing", nullptr, initial,
     "In a mesh, messages go along a column and then a row, from neighbour to neighbour, or straight to "
     "their rank",
     [](Run& o) {
       return choice(o.routing, {{"manhattan", Routing::manhattan}, {"direct", Routing::direct}});
     }},
};

constexpr OptionRow<Run> rank_rows[] = {
    {"--threads-per-rank", "T", nullptr,
     "Threads that share a rank's work: its cores without it; ranks share their machine's cores evenly",
     [](Run& o) { return value(o.threads_per_rank); }},
    {"--transport", nullptr, initial,
     "MPI, or all nodes in this process; auto: MPI when a launcher started it",
     [](Run& o) {
       return choice(o.transport, {{"auto", TransportChoice::automatic},
                                   {"mpi", TransportChoice::mpi},
                                   {"loopback", TransportChoice::loopback}});
     },
     Mark::of_program},
};

constexpr OptionRow<Run> protocol_rows[] = {
    {"--frames-in-flight", nullptr, initial, "Frames announced and not yet complete",
     [](Run& o) { return value(o.protocol.frames_in_flight); }},
    {"--slots", nullptr, initial, "Payloads a Renderer accepts before it has drawn them",
     [](Run& o) { return value(o.protocol.slots); }},
    {"--link-slots", nullptr, initial, "Messages of one buffer class that may be behind a mesh's link",
     [](Run& o) { return value(o.protocol.link_slots); }},
    {"--look-ahead", nullptr, initial,
     "Slices, or bundles of them, that a GP prepares before their tokens have passed",
     [](Run& o) { return value(o.protocol.look_ahead); }},
    {"--send-ahead", nullptr, initial,
     "Payloads that a token leaves behind before it waits until one is accepted",
     [](Run& o) { return value(o.protocol.send_ahead); }},
    {"--keep", "MIB", nullptr,
     "Sheets: MiB of slices that a Renderer keeps, so that later frames need not send them again; without it "
     "a quarter of what a GP's slices take, at least 64",
     [](Run& o) { return value(o.engine.keep, {.least = 0}); }},
    {"--stall-timeout", "SECONDS", initial,
     "Seconds without any progress until it is said which rank is waited for",
     [](Run& o) { return value(o.protocol.stall_timeout); }},
    {"--stall-action", nullptr, initial, "What then comes of the run: it is given up, or waits on",
     [](Run& o) {
       return choice(o.protocol.stall_ends, {{"end", true}, {"wait", false}});
     }},
    {"--shuffle", nullptr, nullptr, "Loopback: messages overtake each other and ranks take turns at random",
     [](Run& o) { return flag(o.loopback.reorder); }},
    {"--max-delay", nullptr, initial, "Loopback: turns by which a message may be late",
     [](Run& o) { return value(o.loopback.max_delay, {.least = 0}); }},
    {"--in-step", nullptr, nullptr,
     "Loopback: one frame at a time, and all tokens move one GP per step of a common clock",
     [](Run& o) { return flag(o.loopback.in_step); }},
    {"--seed", nullptr, initial, "Seed of what is random",
     [](Run& o) { return value(o.loopback.seed, {.least = 0}); }},
};

constexpr OptionRow<Run> machine_rows[] = {
    {"--machine", "FILE", nullptr, "Charge what this described machine's nodes would spend",
     [](Run& o) { return value(o.machine); }},
    {"--count-only", nullptr, nullptr,
     "Send payloads of the right size but draw nothing: for time and traffic, no picture",
     [](Run& o) { return flag(o.simulation.count_only); }},
    {"--voxel-weight", nullptr, initial,
     "With --count-only: so many voxels of its slice for which each voxel stands",
     [](Run& o) {
       return value(o.simulation.voxel_weight, {1.0, 1e6});
     }},
    {"--step-seconds", nullptr, initial,
     "Tokens move one GP per step of a common clock, which lasts so long; 0: freely",
     [](Run& o) {
       return value(o.simulation.step_seconds, {0.0, 1e6});
     }},
};

using Info = InfoOptions;
constexpr OptionRow<Info> info_output_rows[] = {
    {"--gps", "G", nullptr, "Predict the memory of a GP for G of them",
     [](Info& o) {
       return value(o.gps, {1, 1 << 24});
     }},
    {"--bundle", "K", initial, "Predict for bundles of so many slices",
     [](Info& o) {
       return value(o.bundle, {1, most_slices_of_bundle});
     }},
    {"--json", nullptr, nullptr, "Write JSON", [](Info& o) { return flag(o.json); }},
    {"--presets", nullptr, nullptr, "List the transfer functions that --tf knows by name",
     [](Info& o) { return flag(o.presets); }},
};

constexpr OptionRow<Info> prediction_rows[] = {
    {"--ranks", "N", nullptr, "Predict a frame's time for all ways to give N ranks roles",
     [](Info& o) {
       return value(o.ranks, {1, 4096});
     }},
    {"--cores", "C", nullptr, "Cores that the ranks share; without it this machine's",
     [](Info& o) {
       return value(o.cores, {1, 1 << 24});
     }},
    {"--machine", "FILE", nullptr, "Predict for a described machine (docs/simulation.md) instead of this one",
     [](Info& o) { return value(o.machine); }},
};

using Compare = CompareOptions;
constexpr OptionRow<Compare> compare_rows[] = {
    {"a", "A", nullptr, "The picture in question", [](Compare& o) { return value(o.a); }, Mark::required},
    {"b", "B", nullptr, "What it is compared with", [](Compare& o) { return value(o.b); }, Mark::required},
    {"--threshold", nullptr, initial, "Count the pixels that differ by more than this, in 1/255",
     [](Compare& o) { return value(o.threshold, {.least = 0}); }},
    {"--fail-above", nullptr, nullptr, "Exit with 1 when the RMSE is above this, in 1/255",
     [](Compare& o) { return value(o.fail_above, {.least = 0}); }},
    {"--diff", "FILE", nullptr, "Write the difference: absolute, in an .exr signed",
     [](Compare& o) { return value(o.difference); }},
    {"--diff-scale", nullptr, initial, "Multiply the written difference",
     [](Compare& o) { return value(o.difference_scale); }},
    {"--json", nullptr, nullptr, "Write JSON", [](Compare& o) { return flag(o.json); }},
};

using Synth = SynthOptions;
constexpr OptionRow<Synth> synth_rows[] = {
    {"name", "NAME", nullptr, "Which volume; --list says what there is",
     [](Synth& o) { return value(o.name); }},
    {"-o,--output", "FILE", nullptr, ".nrrd, .nhdr, .mhd or .raw (dimensions and type then go into its name)",
     [](Synth& o) { return value(o.output); }},
    {"--dims", "XxYxZ", "64x64x64", "Voxels along x, y, z",
     [](Synth& o) { return parsed(o.dims, parse_dims); }},
    {"--type", "TYPE", "uint8", "int8 uint8 int16 uint16 int32 uint32 float32 float64",
     [](Synth& o) { return parsed(o.type, parse_type); }},
    {"--spacing", "XxYxZ", "1x1x1", "Distances between voxels",
     [](Synth& o) { return parsed(o.spacing, parse_spacing); }},
    {"--no-compression", nullptr, nullptr,
     "Write a .nrrd without gzip, so that all ranks can read it at once",
     [](Synth& o) { return flag(o.no_compression); }},
    {"--list", nullptr, nullptr, "List the volumes", [](Synth& o) { return flag(o.list); }},
};

}  // namespace

constexpr OptionGroup<Volume> volume_options{"Volume", volume_rows};
constexpr OptionGroup<Volume> raw_options{"Raw volumes (others describe themselves)", raw_rows};
constexpr OptionGroup<Run> layout_options{"Ranks", layout_rows};
constexpr OptionGroup<Run> rank_options{"Ranks", rank_rows};
constexpr OptionGroup<Run> protocol_options{"Protocol", protocol_rows};
constexpr OptionGroup<Run> machine_options{"Simulated machines (docs/simulation.md)", machine_rows};
constexpr OptionGroup<Info> info_output_options{"Output", info_output_rows};
constexpr OptionGroup<Info> prediction_options{"Prediction", prediction_rows};
constexpr OptionGroup<Compare> compare_options{"Output", compare_rows};
constexpr OptionGroup<Synth> synth_options{"Output", synth_rows};

}  // namespace ringsplat::app
