#include "formats/vti/header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/xml_reader.hpp"

namespace ringsplat::detail {
namespace {

class Parser : XmlReader {
 public:
  explicit Parser(const std::filesystem::path& path) : file_(path) {}

  VtiHeader read() {
    const auto problem = parse([this](std::span<std::byte> window) {
      const auto got = file_.read_some(read_, window);
      read_ += got;
      return got;
    });
    if (!problem.empty()) fail(problem);
    if (!has_image_) fail("it holds no ImageData");
    if (pieces_ == 0) fail("its ImageData has no Piece");
    for (const auto i : appended_) {
      auto& array = header_.arrays[i];
      if (!done_) fail(fmt::format("the array '{}' is appended, but no data is", excerpt(array.name)));
      if (array.begin > file_.size() - appended_begin_)
        fail(fmt::format("the array '{}' begins behind the end of the file", excerpt(array.name)));
      array.format = appended_format_;
      array.begin += appended_begin_;
      array.end = file_.size();
    }
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& what,
                         const std::string& hint = "write it anew with VTK's XML writer") const {
    refuse(file_.path(), hint, "{}", what);
  }
  void on_text(std::string_view text) override {
    if (is_inline_ && !has_text_ && open_.back() == "DataArray")
      has_text_ = text.find_first_not_of(" \t\r\n") != std::string_view::npos;
  }
  void on_document_type() override { fail("it declares a document type"); }

  void on_start(const std::string& name, const Attributes& attributes) override {
    if (is_inline_ && has_text_ && !inline_end_) inline_end_ = begin();
    const std::string within = open_.empty() ? "" : open_.back();
    open_.push_back(name);
    if (within.empty()) return start_file(name, attributes);
    if (name == "ImageData" && open_.size() == 2) return start_image(attributes);
    if (name == "Piece" && within == "ImageData") return start_piece(attributes);
    if (name == "PointData" && within == "Piece") header_.point_scalars = text_in(attributes, "Scalars");
    if (name == "CellData" && within == "Piece") header_.cell_scalars = text_in(attributes, "Scalars");
    if (name == "DataArray" && (within == "PointData" || within == "CellData"))
      return start_array(attributes, within == "CellData");
    if (name == "AppendedData" && open_.size() == 2) start_appended(attributes);
  }

  void on_end() override {
    // An array's keys are elements before or behind its data.
    if (is_inline_ && !has_text_ && open_.back() != "DataArray") inline_begin_ = end();
    if (is_inline_ && open_.back() == "DataArray") {
      header_.arrays.back().begin = inline_begin_;
      header_.arrays.back().end = inline_end_.value_or(std::max(inline_begin_, begin()));
      is_inline_ = false;
    }
    open_.pop_back();
  }

  template <class T>
  std::vector<T> numbers(const Attributes& attributes, const std::string& key, std::size_t count) const {
    const auto found = attributes.find(key);
    if (found == attributes.end()) return {};
    std::vector<T> list;
    for (const auto& word : words_of(found->second)) {
      const auto number = number_in<T>(word);
      if (!number) fail(fmt::format("{} has '{}', line {}", key, excerpt(word), line()));
      list.push_back(*number);
    }
    if (list.size() != count)
      fail(fmt::format("{} has {} numbers, {} are needed, line {}", key, list.size(), count, line()));
    return list;
  }
  /// The value that `text` names, of the few that an attribute may have.
  template <class T>
  T one_of(const std::string& key, const std::string& text,
           std::initializer_list<std::pair<const char*, T>> values) const {
    for (const auto& [name, value] : values)
      if (text == name) return value;
    fail(fmt::format("{} is '{}', line {}", key, excerpt(text), line()));
  }

  void start_file(const std::string& name, const Attributes& attributes) {
    const auto type = text_in(attributes, "type");
    if (name != "VTKFile") fail(fmt::format("it is no VTK file, its XML is of '{}'", excerpt(name)));
    if (type != "ImageData")
      fail(fmt::format("it holds '{}'", excerpt(type)),
           "only ImageData is a volume: resample it to one, in ParaView with Resample To Image");
    header_.big_endian = one_of<bool>("byte_order", text_in(attributes, "byte_order", "LittleEndian"),
                                      {{"LittleEndian", false}, {"BigEndian", true}});
    header_.header_bytes = one_of<int>("header_type", text_in(attributes, "header_type", "UInt32"),
                                       {{"UInt32", 4}, {"UInt64", 8}});
    header_.compressor = one_of<Compressor>("compressor", text_in(attributes, "compressor"),
                                            {{"", Compressor::none},
                                             {"vtkZLibDataCompressor", Compressor::deflate},
                                             {"vtkLZ4DataCompressor", Compressor::lz4},
                                             {"vtkLZMADataCompressor", Compressor::lzma}});
  }

  void set_extent(const std::vector<int>& extent) {
    for (int axis = 0; axis < 3; ++axis) {
      header_.first[axis] = extent[std::size_t(axis) * 2];
      header_.last[axis] = extent[std::size_t(axis) * 2 + 1];
    }
  }

  void start_image(const Attributes& attributes) {
    if (has_image_) fail("it holds ImageData twice");
    has_image_ = true;
    const auto extent = numbers<int>(attributes, "WholeExtent", 6);
    if (extent.empty()) fail("WholeExtent is missing");
    set_extent(extent);
    if (const auto o = numbers<double>(attributes, "Origin", 3); !o.empty())
      header_.origin = {o[0], o[1], o[2]};
    if (const auto s = numbers<double>(attributes, "Spacing", 3); !s.empty())
      header_.spacing = {s[0], s[1], s[2]};
    const auto rows = numbers<double>(attributes, "Direction", 9);
    for (std::size_t i = 0; i < rows.size(); ++i) header_.direction[int(i % 3)][int(i / 3)] = rows[i];
  }

  void start_piece(const Attributes& attributes) {
    if (++pieces_ > 1)
      fail("it holds several pieces", "write it in one piece, or load it in ParaView and save it again");
    if (const auto extent = numbers<int>(attributes, "Extent", 6); !extent.empty()) set_extent(extent);
  }

  void start_array(const Attributes& attributes, bool of_cells) {
    VtiArray array;
    array.name = text_in(attributes, "Name");
    array.type = text_in(attributes, "type");
    array.of_cells = of_cells;
    const auto components = number_in<int>(text_in(attributes, "NumberOfComponents", "1"));
    if (!components || *components < 1)
      fail(fmt::format("the array '{}' has no number of components", excerpt(array.name)));
    array.components = *components;
    const auto format = text_in(attributes, "format", "ascii");
    is_inline_ = format != "appended";
    if (is_inline_) {
      array.format =
          one_of<Encoding>("format", format, {{"ascii", Encoding::text}, {"binary", Encoding::base64}});
      inline_begin_ = end();
      inline_end_.reset();
      has_text_ = false;
    } else {
      const auto offset = number_in<std::uint64_t>(text_in(attributes, "offset"));
      if (!offset) fail(fmt::format("the array '{}' has no offset", excerpt(array.name)));
      array.begin = *offset;
      appended_.push_back(header_.arrays.size());
    }
    header_.arrays.push_back(std::move(array));
  }

  /// Behind an underscore; what it is, is no XML.
  void start_appended(const Attributes& attributes) {
    appended_format_ = one_of<Encoding>("encoding", text_in(attributes, "encoding", "base64"),
                                        {{"base64", Encoding::base64}, {"raw", Encoding::raw}});
    std::array<char, 256> blanks{};
    const auto behind = end();
    const auto got = file_.read_some(behind, std::as_writable_bytes(std::span(blanks)));
    const auto mark = std::string_view(blanks.data(), got).find_first_not_of(" \t\r\n");
    if (mark == std::string_view::npos || blanks[mark] != '_')
      fail("its appended data does not begin with an underscore");
    appended_begin_ = behind + mark + 1;
    done_ = true;
    stop();
  }

  InputFile file_;
  std::uint64_t read_ = 0;  ///< bytes of the file
  VtiHeader header_;
  std::vector<std::string> open_;
  bool has_image_ = false, is_inline_ = false, has_text_ = false;
  bool done_ = false;  ///< the appended data is reached
  int pieces_ = 0;
  std::uint64_t inline_begin_ = 0, appended_begin_ = 0;
  std::optional<std::uint64_t> inline_end_;
  Encoding appended_format_ = Encoding::raw;
  std::vector<std::size_t> appended_;  ///< arrays that have only their offset yet
};

}  // namespace

VtiHeader read_vti_header(const std::filesystem::path& path) { return Parser(path).read(); }

}  // namespace ringsplat::detail
