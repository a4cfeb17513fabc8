#include "decode/dicom/series.hpp"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "base/log.hpp"
#include "base/text.hpp"
#include "decode/dicom/checks.hpp"
#include "decode/readers.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

namespace fs = std::filesystem;

/// An image as a series of its own; nothing for a file that is none.
std::optional<DicomSeries> read_header(const fs::path& path) {
  const auto file = read_dicom_file(path);
  if (!file || !file->pixels) return {};
  const auto shape = check_dicom(*file);
  const auto text = [&](DicomTag tag) { return trimmed(file->elements.text(tag)); };
  DicomSeries series{.uid = text(dicom::series),
                     .description = text(dicom::description),
                     .modality = text(dicom::modality),
                     .number = text(dicom::series_number),
                     .rescale_type = text(dicom::rescale_type)};
  series.images.push_back(
      {.file = path, .instance = text(dicom::instance), .frames = shape.frames, .times = dicom_times(*file)});
  return series;
}

/// The files of a folder and, when `deep`, of those below it, by their paths.
std::vector<fs::path> files_in(const fs::path& folder, bool deep) {
  constexpr int deepest = 12;
  constexpr std::size_t most_files = 200'000;
  std::vector<fs::path> files;
  std::set<fs::path> visited{fs::canonical(folder)};
  fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink);
  for (; entry != fs::end(entry); ++entry) {
    std::error_code broken;  // a link that leads nowhere is no image
    if (entry->is_regular_file(broken) && entry->file_size(broken) > 0)  // the kernel's own have none
      files.push_back(entry->path());
    bool enter = deep && entry.depth() < deepest && entry->is_directory(broken) &&
                 visited.insert(fs::canonical(entry->path(), broken)).second;
    if (enter) {
      // One that cannot be opened, or is gone since it was listed, would end the walk.
      const fs::directory_iterator opened(entry->path(), broken);
      enter = !broken;
      if (!enter && broken != std::errc::no_such_file_or_directory)
        log_warning_once("left out: {}: {}", entry->path().string(), broken.message());
    }
    if (!enter) entry.disable_recursion_pending();
    if (files.size() > most_files)
      throw InputError(fmt::format("{} holds more than {} files", folder.string(), most_files),
                       "give the folder of one study or series");
  }
  std::sort(files.begin(), files.end());
  return files;
}

void tell(const std::vector<InputError>& problems, const fs::path& folder) {
  constexpr std::size_t most = 5;
  for (std::size_t i = 0; i < std::min(problems.size(), most); ++i)
    log_warning_once("left out: {}", problems[i].what());
  if (problems.size() > most)
    log_warning_once("left out: {} more files of {} that cannot be read", problems.size() - most,
                     folder.string());
}

/// The end of a UID, long enough to be the only one that ends so.
std::string short_uid(const DicomSeries& one, const std::vector<DicomSeries>& all) {
  constexpr std::size_t least = 8;
  for (auto length = least; length < one.uid.size(); ++length) {
    const auto end = one.uid.substr(one.uid.size() - length);
    const auto same = [&](const DicomSeries& s) { return s.uid.ends_with(end); };
    if (end[0] != '.' && std::count_if(all.begin(), all.end(), same) == 1) return fmt::format("...{}", end);
  }
  return one.uid;
}

/// Nothing for an empty text.
std::string told(fmt::format_string<std::string> how, const std::string& text) {
  return text.empty() ? std::string() : fmt::format(how, excerpt(text));
}

std::string describe(const DicomSeries& one, const std::vector<DicomSeries>& all) {
  return fmt::format("{} {}{}{}{}, UID {}", one.slices(), one.slices() == 1 ? "slice" : "slices",
                     told(" {}", one.modality), told(", series {}", one.number),
                     told(", '{}'", one.description), short_uid(one, all));
}

std::string list_of(const std::vector<DicomSeries>& series) {
  constexpr std::size_t most = 10;
  auto lines = describe(series);
  if (lines.size() > most) {
    lines[most] = fmt::format("{} more", lines.size() - most);
    lines.resize(most + 1);
  }
  return joined(lines, "; ");
}

using Matches = std::vector<const DicomSeries*>;

/// What a name means, from the surest meaning on: the first that any series has counts.
Matches find_named(const std::vector<DicomSeries>& series, const std::string& wanted) {
  const std::function<bool(const DicomSeries&)> meanings[] = {
      [&](const DicomSeries& s) { return s.uid == wanted; },
      [&](const DicomSeries& s) { return s.number == wanted; },
      [&](const DicomSeries& s) { return lower_case(s.description) == lower_case(wanted); },
      [&](const DicomSeries& s) { return s.uid.starts_with(wanted) || s.uid.ends_with(wanted); }};
  Matches matches;
  for (const auto& meant : meanings) {
    for (const auto& s : series)
      if (meant(s)) matches.push_back(&s);
    if (!matches.empty()) break;
  }
  return matches;
}

}  // namespace

std::vector<DicomSeries> find_series(const fs::path& folder, bool deep) {
  std::map<std::string, DicomSeries> series;
  std::set<std::pair<std::string, std::string>> instances;
  std::size_t copies = 0;
  std::vector<InputError> problems;
  for (const auto& file : files_in(folder, deep)) {
    progress(fs::file_size(file));
    try {
      if (auto image = read_header(file)) {
        const auto& instance = image->images.front().instance;
        if (!instance.empty() && !instances.emplace(image->uid, instance).second) {
          ++copies;  // exports often hold files twice
          continue;
        }
        const auto [found, is_new] = series.try_emplace(image->uid, *image);
        if (!is_new) found->second.images.push_back(std::move(image->images.front()));
      } else if (lower_case(file.extension().string()) == ".dcm" && !is_dicom(file))
        throw InputError(fmt::format("{} is no DICOM file", file.string()), "copy the file again");
    } catch (const InputError& error) {
      problems.push_back(error);
    }
  }
  if (series.empty() && problems.size() == 1) throw InputError(problems.front());
  if (series.empty() && !problems.empty())
    throw InputError(fmt::format("{} holds no image that can be read; of {} the first: {}", folder.string(),
                                 problems.size(), problems.front().what()));
  tell(problems, folder);
  if (copies > 0) log_warning_once("{}: {} files are copies of others and left out", folder.string(), copies);
  return mapped(series, [](auto& one) { return std::move(one.second); });
}

std::vector<DicomSeries> find_series_of(const fs::path& file) {
  const auto image = read_header(file);
  if (!image) return {};
  if (image->images.front().frames > 1) return {*image};
  auto all = find_series(fs::absolute(file).parent_path(), false);
  std::erase_if(all, [&](const DicomSeries& s) { return s.uid != image->uid; });
  return all;
}

std::vector<std::string> describe(const std::vector<DicomSeries>& series) {
  return mapped(series, [&](const auto& one) { return describe(one, series); });
}

const DicomSeries& choose_series(const std::vector<DicomSeries>& series, const std::string& wanted,
                                 const std::string& where) {
  if (!wanted.empty()) {
    const auto matches = find_named(series, wanted);
    if (matches.size() == 1) return *matches[0];
    throw InputError(
        fmt::format("--series {}: {} has {} such series", wanted, where,
                    matches.empty() ? "no" : std::to_string(matches.size())),
        fmt::format("give a number, a description or an ending of a UID of these: {}", list_of(series)));
  }
  const auto longest = std::ranges::max_element(series, {}, &DicomSeries::slices);
  if (series.size() > 1)
    log_warning_once("{} holds {} DICOM series, taken is the longest ({} slices); --series takes another: {}",
                     where, series.size(), longest->slices(), list_of(series));
  return *longest;
}

}  // namespace ringsplat::detail
