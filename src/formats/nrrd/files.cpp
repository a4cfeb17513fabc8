#include "formats/nrrd/files.hpp"

#include <NrrdIO.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <string>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

/// Where the first %d, %03d … ends; npos if there is none.
std::size_t end_of_number(std::string_view name) {
  for (auto at = name.find('%'); at != name.npos; at = name.find('%', at + 1)) {
    auto end = at + 1;
    while (end < name.size() && std::isdigit(static_cast<unsigned char>(name[end])) != 0) ++end;
    if (end < name.size() && name[end] == 'd') return end + 1;
  }
  return name.npos;
}

bool is_plain(std::string_view name) {
  const auto end = end_of_number(name);
  if (end == name.npos) return true;  // a name, no pattern
  const auto percent = name.find('%');
  constexpr std::size_t longest = 4;  // %09d
  return std::count(name.begin(), name.end(), '%') == 1 && end - percent <= longest;
}

/// Comments, key/value pairs and the content are never quoted.
void require_quotable(const std::filesystem::path& header, const std::string& line, int number) {
  constexpr std::size_t longest = 400;  // bytes; NrrdIO's messages have about 1000, for two lines at most
  const bool is_free = line.front() == '#' || line.find(":=") != line.npos || line.rfind("content:", 0) == 0;
  if (line.size() > longest && !is_free)
    throw InputError(fmt::format("{}: line {} has {} bytes", header.string(), number, line.size()),
                     "shorten it, and the names of data files by links to them");
}

/// NrrdIO loses the last name of a list that ends without a line break, and reads past its memory.
void require_line_break_at_end(const std::filesystem::path& header) {
  std::ifstream stream(header, std::ios::binary);
  if (stream.seekg(-1, std::ios::end) && stream.get() == '\n') return;
  throw InputError(fmt::format("{}: its list of data files does not end with a line break", header.string()),
                   "add one after the last name");
}

}  // namespace

void require_nrrdio_can_read(const std::filesystem::path& header) {
  std::ifstream stream(header, std::ios::binary);
  std::string line;
  bool lists_files = false;
  for (int number = 1; std::getline(stream, line) && !one_line(line).empty(); ++number) {
    if (number == 1 && line.rfind("NRRD", 0) != 0) return;
    require_quotable(header, line, number);
    const auto colon = std::min(line.find(':'), line.size());
    const auto key = lower_case(one_line(line.substr(0, colon)));
    const auto value = one_line(line.substr(std::min(colon + 1, line.size())));
    if (key == "data file" || key == "datafile") {
      lists_files = value.rfind("LIST", 0) == 0;
      if (!is_plain(value))
        throw InputError(fmt::format("{}: the pattern of its data files is '{}'", header.string(), value),
                         "give a name with one number, such as slice%03d.raw 1 60 1");
    } else if (number > 1 && colon == line.size() && line.front() != '#' && !lists_files) {
      return;  // not a header line: NrrdIO stops here
    }
  }
  if (lists_files) require_line_break_at_end(header);
}

void for_data_files(const std::filesystem::path& header, const NrrdIoState& io,
                    const std::function<void(const std::filesystem::path&, std::uint64_t)>& use) {
  const auto folder = header.parent_path();
  if (io.dataFNFormat == nullptr) {
    for (unsigned k = 0; k < io.dataFNArr->len; ++k) use(folder / io.dataFN[k], io.dataFNArr->len);
    return;
  }
  const std::int64_t first = io.dataFNMin, last = io.dataFNMax, step = io.dataFNStep;
  const std::int64_t count = step == 0 ? 1 : std::max<std::int64_t>((last - first) / step + 1, 0);
  for (std::int64_t k = 0; k < count; ++k) {
    std::array<char, 4096> name{};
    // The pattern is safe for snprintf: require_nrrdio_can_read() has checked it.
    const int length = std::snprintf(name.data(), name.size(), io.dataFNFormat, int(first + k * step));
    if (length < 0 || std::size_t(length) >= name.size())
      throw InputError(fmt::format("{}: the names of its data files are too long", header.string()),
                       "shorten them");
    use(folder / name.data(), std::uint64_t(count));
  }
}

}  // namespace ringsplat::detail
