#include "formats/vti/header.hpp"

#include <initializer_list>
#include <iterator>
#include <string_view>
#include <utility>

#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/xml_reader.hpp"

namespace ringsplat::detail {
namespace {

class Parser : XmlReader {
 public:
  /// `of_pieces`: it may be a .pvti file.
  Parser(const std::filesystem::path& path, bool of_pieces) : file_(path), of_pieces_(of_pieces) {}

  VtiHeader read() {
    const auto problem = parse([this](std::span<std::byte> window) {
      const auto got = file_.read_some(read_, window);
      read_ += got;
      return got;
    });
    if (!problem.empty()) fail(problem);
    if (!has_image_) fail("it holds no ImageData");
    if (header_.pieces.empty()) fail("its ImageData has no Piece");
    for (const auto& [piece, i] : appended_) {
      auto& array = header_.pieces[piece].arrays[i];
      if (!done_) fail(fmt::format("the array '{}' is appended, but no data is", excerpt(array.name)));
      if (array.begin > file_.size() - appended_begin_)
        fail(fmt::format("the array '{}' begins behind the end of the file", excerpt(array.name)));
      array.format = appended_format_;
      array.begin += appended_begin_;
      array.end = file_.size();
    }
    // A piece by itself counts as the whole.
    if (header_.pieces.size() == 1 && !of_files_) {
      header_.first = header_.pieces[0].first;
      header_.last = header_.pieces[0].last;
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
    if (name == kind_ && open_.size() == 2) return start_image(attributes);
    if (name == "Piece" && within == kind_) return of_files_ ? add_file(attributes) : start_piece(attributes);
    if (name == "PointData" && within == "Piece") header_.point_scalars = text_in(attributes, "Scalars");
    if (name == "CellData" && within == "Piece") header_.cell_scalars = text_in(attributes, "Scalars");
    const bool in_piece = !of_files_ && !header_.pieces.empty();
    if (in_piece && name == "DataArray" && (within == "PointData" || within == "CellData"))
      return start_array(attributes, within == "CellData");
    if (name == "AppendedData" && open_.size() == 2) start_appended(attributes);
  }

  void on_end() override {
    // An array's keys are elements before or behind its data.
    if (is_inline_ && !has_text_ && open_.back() != "DataArray") inline_begin_ = end();
    if (is_inline_ && open_.back() == "DataArray") {
      auto& array = header_.pieces.back().arrays.back();
      array.begin = inline_begin_;
      array.end = inline_end_.value_or(std::max(inline_begin_, begin()));
      is_inline_ = false;
    }
    open_.pop_back();
  }

  template <class T>
  std::vector<T> numbers(const Attributes& attributes, const std::string& key, std::size_t count) const {
    const auto found = attributes.find(key);
    if (found == attributes.end()) return {};
    auto list = mapped(words_of(found->second), [&](const std::string& word) {
      const auto number = number_in<T>(word);
      if (!number) fail(fmt::format("{} has '{}', line {}", key, excerpt(word), line()));
      return *number;
    });
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
    kind_ = text_in(attributes, "type");
    of_files_ = of_pieces_ && kind_ == "PImageData";
    if (name != "VTKFile") fail(fmt::format("it is no VTK file, its XML is of '{}'", excerpt(name)));
    if (kind_ != "ImageData" && !of_files_)
      fail(fmt::format("it holds '{}'", excerpt(kind_)),
           "only ImageData is a volume: resample it to one, in ParaView with Resample To Image");
    plain_.big_endian = one_of<bool>("byte_order", text_in(attributes, "byte_order", "LittleEndian"),
                                     {{"LittleEndian", false}, {"BigEndian", true}});
    plain_.header_bytes = one_of<int>("header_type", text_in(attributes, "header_type", "UInt32"),
                                      {{"UInt32", 4}, {"UInt64", 8}});
    plain_.compressor = one_of<Compressor>("compressor", text_in(attributes, "compressor"),
                                           {{"", Compressor::none},
                                            {"vtkZLibDataCompressor", Compressor::deflate},
                                            {"vtkLZ4DataCompressor", Compressor::lz4},
                                            {"vtkLZMADataCompressor", Compressor::lzma}});
  }

  /// Leaves points alone where there is no such extent.
  void read_extent(const Attributes& attributes, const char* key, glm::ivec3& first, glm::ivec3& last) const {
    const auto extent = numbers<int>(attributes, key, 6);
    if (extent.empty()) return;
    first = {extent[0], extent[2], extent[4]};
    last = {extent[1], extent[3], extent[5]};
  }

  void start_image(const Attributes& attributes) {
    if (has_image_) fail("it holds ImageData twice");
    has_image_ = true;
    if (!attributes.contains("WholeExtent")) fail("WholeExtent is missing");
    read_extent(attributes, "WholeExtent", header_.first, header_.last);
    if (of_files_) header_.ghosts = number_in<int>(text_in(attributes, "GhostLevel", "0")).value_or(0);
    if (const auto o = numbers<double>(attributes, "Origin", 3); !o.empty())
      header_.origin = {o[0], o[1], o[2]};
    if (const auto s = numbers<double>(attributes, "Spacing", 3); !s.empty())
      header_.spacing = {s[0], s[1], s[2]};
    const auto rows = numbers<double>(attributes, "Direction", 9);
    for (std::size_t i = 0; i < rows.size(); ++i) header_.direction[int(i % 3)][int(i / 3)] = rows[i];
  }

  void start_piece(const Attributes& attributes) {
    header_.pieces.push_back({file_.path(), header_.first, header_.last, {}});
    read_extent(attributes, "Extent", header_.pieces.back().first, header_.pieces.back().last);
  }

  /// Of a .pvti file: the piece is a file of its own, which knows its arrays.
  void add_file(const Attributes& attributes) {
    const auto source = text_in(attributes, "Source");
    if (source.empty()) fail(fmt::format("a Piece has no Source, line {}", line()));
    auto piece = Parser(file_.path().parent_path() / source, false).read();
    if (header_.pieces.empty()) {
      header_.point_scalars = piece.point_scalars;
      header_.cell_scalars = piece.cell_scalars;
    }
    std::ranges::move(piece.pieces, std::back_inserter(header_.pieces));
  }

  void start_array(const Attributes& attributes, bool of_cells) {
    VtiArray array = plain_;
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
      appended_.push_back({header_.pieces.size() - 1, header_.pieces.back().arrays.size()});
    }
    header_.pieces.back().arrays.push_back(std::move(array));
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
  bool of_pieces_, of_files_ = false;
  std::uint64_t read_ = 0;  ///< bytes of the file
  VtiHeader header_;
  VtiArray plain_;    ///< how the file has binary data
  std::string kind_;  ///< ImageData or PImageData
  std::vector<std::string> open_;
  bool has_image_ = false, is_inline_ = false, has_text_ = false;
  bool done_ = false;  ///< the appended data is reached
  std::uint64_t inline_begin_ = 0, appended_begin_ = 0;
  std::optional<std::uint64_t> inline_end_;
  Encoding appended_format_ = Encoding::raw;
  /// Pieces and their arrays that have only their offset yet.
  std::vector<std::pair<std::size_t, std::size_t>> appended_;
};

}  // namespace

VtiHeader read_vti_header(const std::filesystem::path& path) { return Parser(path, true).read(); }

}  // namespace ringsplat::detail
