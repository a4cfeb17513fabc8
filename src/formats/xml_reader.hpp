#pragma once
#include <expat.h>
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>

namespace ringsplat::detail {

/// Calls a derived class for what expat finds in XML, in order. What these calls throw comes out of parse().
class XmlReader {
 public:
  using Attributes = std::map<std::string, std::string>;

  virtual ~XmlReader() = default;

 protected:
  /// `encoding`: what the text says of it counts when this is null.
  explicit XmlReader(const char* encoding = nullptr) : parser_(XML_ParserCreate(encoding), &XML_ParserFree) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(), [](void* self, const char* name, const char** all) { start(self, name, all); },
        [](void* self, const char*) { guarded(self, [](auto& reader) { reader.on_end(); }); });
    XML_SetCharacterDataHandler(parser_.get(), [](void* self, const char* text, int length) {
      guarded(self, [&](auto& reader) { reader.on_text({text, std::size_t(length)}); });
    });
    XML_SetStartDoctypeDeclHandler(parser_.get(), [](void* self, const char*, const char*, const char*, int) {
      guarded(self, [](auto& reader) { reader.on_document_type(); });
    });
  }

  /// Until the end or stop(). `more` fills a span's beginning and returns how many bytes, 0 at the end.
  /// Returns what is wrong with the text; empty when nothing is.
  template <class More>
  std::string parse(More&& more) {
    constexpr int window_bytes = 64 * 1024;
    for (bool last = false; !last && !stopped_;) {
      void* window = XML_GetBuffer(parser_.get(), window_bytes);
      if (window == nullptr) throw std::bad_alloc();
      const std::size_t got = more(std::span(static_cast<std::byte*>(window), std::size_t(window_bytes)));
      last = got == 0;
      const auto status = XML_ParseBuffer(parser_.get(), int(got), last ? 1 : 0);
      if (error_) std::rethrow_exception(error_);
      if (status != XML_STATUS_OK && !stopped_)
        return fmt::format("line {} is no XML: {}", line(), XML_ErrorString(XML_GetErrorCode(parser_.get())));
    }
    return {};
  }
  void stop() {
    stopped_ = true;
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  // Where the tag or text is that was found.
  int line() const { return int(XML_GetCurrentLineNumber(parser_.get())); }
  std::uint64_t begin() const { return std::uint64_t(XML_GetCurrentByteIndex(parser_.get())); }
  std::uint64_t end() const { return begin() + std::uint64_t(XML_GetCurrentByteCount(parser_.get())); }

 private:
  virtual void on_start(const std::string& name, const Attributes& attributes) = 0;
  virtual void on_end() {}
  virtual void on_text(std::string_view) {}
  /// A document type could declare entities of any size.
  virtual void on_document_type() { stop(); }

  /// Exceptions must not pass through expat.
  template <class F>
  static void guarded(void* self, F&& f) noexcept {
    auto& reader = *static_cast<XmlReader*>(self);
    if (reader.error_ || reader.stopped_) return;
    try {
      f(reader);
    } catch (...) {
      reader.error_ = std::current_exception();
      reader.stop();
    }
  }
  static void start(void* self, const char* name, const char** attributes) {
    guarded(self, [&](XmlReader& reader) {
      Attributes list;
      for (; *attributes != nullptr; attributes += 2) list.emplace(attributes[0], attributes[1]);
      reader.on_start(name, list);
    });
  }

  std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser_;
  std::exception_ptr error_;
  bool stopped_ = false;
};

inline std::string text_in(const XmlReader::Attributes& attributes, const std::string& key,
                           const std::string& otherwise = {}) {
  const auto found = attributes.find(key);
  return found == attributes.end() ? otherwise : found->second;
}

}  // namespace ringsplat::detail
