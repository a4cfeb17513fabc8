#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "images/image_io.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

struct Gaussians : Workshop {
  explicit Gaussians(const char* quality = "paper")
      : Workshop("gaussians", "24x24x24",
                 {"--size", "64x48", "--tf", "grey", "--shading", "none", "--azimuth", "20", "--elevation",
                  "10", "--quality", quality}) {}
  void reference(const std::string& picture, const Words& more = {}) const {
    Words all = words(picture, more);
    all[0] = "reference";
    succeeded(run_program(all));
  }
};

Ended must(const Words& words, int ranks = 0) { return succeeded(run_program(words, ranks)); }

double rmse_of(const Gaussians& w, const std::string& a, const std::string& b) {
  return json::parse(must({"compare", w / a, w / b, "--json"}).out).at("rmse").get<double>();
}

}  // namespace

TEST_CASE("reference: the picture lies nearest to the method's truth, then the field's", "[mpi]") {
  const Gaussians w;
  w.render("picture.exr");
  w.reference("method.exr", {"--truth", "method"});
  w.reference("field.exr");
  w.reference("formula.exr", {"--truth", "analytic", "--formula", "gaussians"});
  CHECK(rmse_of(w, "picture.exr", "method.exr") < 1e-3);
  CHECK(rmse_of(w, "picture.exr", "field.exr") > 0.1);
  CHECK(rmse_of(w, "picture.exr", "field.exr") < 5);
  CHECK(rmse_of(w, "field.exr", "formula.exr") < 2.5);
  const std::vector<std::string> white{"--background", "white"};
  w.render("picture.png", white);
  w.reference("field.png", white);
  CHECK(rmse_of(w, "picture.png", "field.png") < 5);
  const json settings = json::parse(read_image(w / "field.exr").settings);
  CHECK(settings.at("truth") == "field");
  CHECK(settings.at("tolerance") == 1e-6);
}

TEST_CASE("render --error says the same as compare with the whole truth, in one process and on ranks",
          "[mpi]") {
  const Gaussians w;
  const std::vector<std::string> measuring{"--error", "field",   "--error-pixels",
                                           "10000",   "--stats", w / "stats.json"};
  w.reference("field.exr");
  for (const int ranks : {0, 3}) {
    const Ended ended = w.render("picture.exr", measuring, ranks);
    CHECK_THAT(ended.out, Catch::Matchers::Contains("error against the field's truth"));
    const json in_stats = json::parse(read_text(w / "stats.json")).at(0).at("error");
    const json in_picture = json::parse(read_image(w / "picture.exr").settings).at("error");
    const double rmse = rmse_of(w, "picture.exr", "field.exr");
    CHECK(in_stats.at("pixels").get<int>() + in_stats.at("outside").get<int>() == 64 * 48);
    CHECK(in_stats.at("outside") > 0);
    CHECK(in_stats.at("rmse").get<double>() == Approx(rmse).epsilon(1e-4));
    CHECK(in_picture.at("rmse") == in_stats.at("rmse"));
    CHECK(in_stats.contains("seconds"));
    CHECK_FALSE(in_picture.contains("seconds"));
  }
  std::vector<json> sampled;
  for (const int ranks : {0, 3}) {
    w.render("picture.exr", {"--error", "field", "--error-pixels", "500"}, ranks);
    sampled.push_back(json::parse(read_image(w / "picture.exr").settings).at("error"));
  }
  CHECK(sampled[0] == sampled[1]);
  CHECK(sampled[0].at("pixels") == 500);
  CHECK(sampled[0].at("rmse_low") < sampled[0].at("rmse"));
  CHECK(sampled[0].at("rmse_high") > sampled[0].at("rmse"));
}

TEST_CASE("a certificate holds what is measured, on any ranks", "[mpi]") {
  const Gaussians w;
  const std::vector<std::string> all{"--error-pixels", "10000", "--stats", w / "stats.json"};
  w.render("picture.exr", joined(all, {"--error", "field"}));
  const json field = json::parse(read_text(w / "stats.json")).at(0).at("error");
  std::vector<json> certified;
  for (const int ranks : {0, 3}) {
    const Ended ended = w.render("picture.exr", joined(all, {"--error", "certified"}), ranks);
    CHECK_THAT(ended.out, Catch::Matchers::Contains("error certified against the field"));
    certified.push_back(json::parse(read_image(w / "picture.exr").settings).at("error"));
  }
  const json& error = certified[0];
  CHECK(error == certified[1]);
  for (const char* figure : {"rmse", "largest"}) {
    const double measured = field.at(figure);
    CHECK(error.at(figure + std::string("_low")) <= measured + 1e-6);
    CHECK(error.at(figure == std::string("rmse") ? "rmse_high" : "largest") >= measured - 1e-6);
  }
  CHECK(error.at("widest") <= 0.1);
  CHECK(error.at("largest").get<double>() - error.at("largest_low").get<double>() <= 0.1);
  CHECK(error.at("proved").size() == error.at("proved_within").size());
  CHECK(error.at("proved").at(0) <= error.at("proved").at(2));

  w.reference("field.exr");
  w.reference("middle.exr", {"--truth", "certified"});
  CHECK(rmse_of(w, "middle.exr", "field.exr") < 0.05);
}

TEST_CASE("ranks that are bound to cores measure together, and say and draw what one process does", "[mpi]") {
  const Gaussians w("best");
  // Nothing is left to be chosen by time.
  const Words fixed{"--slabs",       "2",      "--opaque-threshold", "0",
                    "--image-plane", "screen", "--undersample",      "1"};
  const Words guarantee = joined(fixed, {"--error", "certified", "--max-error", "0.2", "--guarantee"});
  for (const Words& options :
       {Words{"--error", "method"}, Words{"--error", "field", "--orbit", "3"}, guarantee}) {
    std::vector<json> errors;
    std::vector<Image> pictures;
    for (const int ranks : {0, 2}) {
      setenv("OMPI_MCA_hwloc_base_binding_policy", "core", 1);
      w.render("picture.exr", joined(options, {"--stats", w / "stats.json"}), ranks);
      unsetenv("OMPI_MCA_hwloc_base_binding_policy");
      json& all = errors.emplace_back();
      for (const json& frame : json::parse(read_text(w / "stats.json"))) {
        all.push_back(frame.at("error"));
        all.back().erase("seconds");
        pictures.push_back(read_image(frame.at("file").get<std::string>()).image);
      }
    }
    INFO(options.back());
    CHECK(errors[0] == errors[1]);
    for (std::size_t k = 0; k < pictures.size() / 2; ++k)
      CHECK(pictures[k] == pictures[k + pictures.size() / 2]);
  }
}

TEST_CASE("extrema and integrals of the head are certified, on any ranks", "[mpi]") {
  const Gaussians w;
  const auto command = [&](const std::string& name, const std::string& mode) {
    return std::vector<std::string>{name,          RINGSPLAT_TEST_DATA "/head.nrrd",
                                    "-o",          w / (name + ".exr"),
                                    "--size",      "48x48",
                                    "--azimuth",   "20",
                                    "--elevation", "10",
                                    "--mode",      mode};
  };
  for (const std::string mode : {"mip", "sum"}) {
    must(joined(command("reference", mode), {"--truth", "field"}));
    std::vector<json> errors;
    for (const int ranks : {1, 2}) {
      const Ended ended =
          must(joined(command("render", mode), {"--error", "certified", "--error-pixels", "10000"}), ranks);
      CHECK_THAT(ended.out, Catch::Matchers::Contains("error certified against the field"));
      errors.push_back(json::parse(read_image(w / "render.exr").settings).at("error"));
      const json apart = json::parse(must({"compare", w / "render.exr", w / "reference.exr", "--json"}).out);
      // The reference is rounded to float32.
      CHECK(apart.at("largest").get<double>() <= errors.back().at("largest").get<double>() + 1e-4);
      CHECK(apart.at("largest").get<double>() >= errors.back().at("largest_low").get<double>() - 1e-4);
    }
    CHECK(errors[0] == errors[1]);
    CHECK(errors[0].at("largest") < 1);
    CHECK(errors[0].at("widest") < 1e-4);
  }
  must(joined(command("reference", "sum"), {"--truth", "certified"}));
  CHECK(rmse_of(w, "render.exr", "reference.exr") < 0.1);
}

TEST_CASE("a guarantee holds for every pixel, on any ranks", "[mpi]") {
  const Gaussians w("best");
  w.reference("field.exr");
  const std::vector<std::string> proved{"--error", "certified", "--max-error", "0.2", "--guarantee"};
  for (const int ranks : {0, 3}) {
    const Ended ended = w.render("picture.exr", proved, ranks);
    CHECK_THAT(ended.out, Catch::Matchers::Contains("pixels replaced"));
    const json error = json::parse(read_image(w / "picture.exr").settings).at("error");
    CHECK(error.at("replaced") > 0);
    CHECK(error.at("largest") <= 0.2);
    CHECK(error.at("pixels").get<int>() + error.at("outside").get<int>() == 64 * 48);
    const json apart = json::parse(must({"compare", w / "picture.exr", w / "field.exr", "--json"}).out);
    CHECK(apart.at("largest") <= 0.2);
  }
  // Bounds are not as narrow as this.
  const std::vector<std::string> too_much{"--error", "certified", "--max-error", "1e-5", "--guarantee"};
  const Ended ended = w.run("most.exr", too_much, 3);
  CHECK(ended.code == 1);
  CHECK_THAT(ended.err,
             Catch::Matchers::Contains("breaks --max-error 1e-05") && Catch::Matchers::Contains("hint:"));
  CHECK(rmse_of(w, "most.exr", "field.exr") < 0.05);
}

TEST_CASE("a map shows where a picture errs", "[mpi]") {
  const Gaussians w;
  const std::vector<std::string> mapped{"--error", "field", "--error-map", w / "map.exr"};
  const auto opaque = [&] {
    const Image map = read_image(w / "map.exr").image;
    std::size_t count = 0;
    for (std::size_t k = 3; k < map.rgba.size(); k += 4) count += map.rgba[k] == 1;
    return count;
  };
  for (const int ranks : {0, 3}) {
    w.render("picture.exr", mapped, ranks);
    CHECK(opaque() == 64 * 48);
    const StoredImage map = read_image(w / "map.exr");
    const json settings = json::parse(map.settings);
    const double rmse = settings.at("error").at("rmse"), top = settings.at("error_map").at("to");
    CHECK((top >= 4 * rmse && top <= 10 * rmse));
    // Green grows with the error up to the end of the scale.
    w.reference("field.exr");
    const Image picture = read_image(w / "picture.exr").image, field = read_image(w / "field.exr").image;
    std::vector<std::pair<double, float>> pixels;
    for (std::size_t p = 0; p < picture.rgba.size(); p += 4) {
      double error = 0;
      for (std::size_t c = p; c < p + 4; ++c)
        error = std::max(error, 255 * std::abs(double(picture.rgba[c]) - double(field.rgba[c])));
      if (error < top) pixels.emplace_back(error, map.image.rgba[p + 1]);
    }
    std::sort(pixels.begin(), pixels.end());
    std::size_t fallen = 0;
    for (std::size_t k = 1; k < pixels.size(); ++k) fallen += pixels[k].second < pixels[k - 1].second - 0.01F;
    CHECK(fallen == 0);
    CHECK(pixels.back().second > pixels.front().second + 0.1F);
  }
  w.render("picture.exr", joined(mapped, {"--error-pixels", "50"}));
  const json error = json::parse(read_image(w / "map.exr").settings).at("error");
  CHECK(error.at("pixels") == 50);
  CHECK(opaque() == 50 + error.at("outside").get<std::size_t>());
  w.render("picture.exr", joined(mapped, {"--orbit", "2", "--error-pixels", "50"}));
  CHECK(fs::exists(w / "map-0001.exr"));
}

TEST_CASE("an orbit's frames are each measured", "[mpi]") {
  const Gaussians w;
  const Ended ended = w.render("picture.exr", {"--orbit", "3", "--error", "method", "--error-pixels", "200"});
  CHECK(lines_with(ended.out, "error against the method's truth").size() == 3);
  CHECK(fs::exists(w / "picture-0002.exr"));
}

TEST_CASE("a small volume's error is measured where the volume is, not where nothing can be wrong") {
  const Gaussians w;
  const std::vector<std::string> far{"--zoom", "0.2"};
  w.reference("field.exr", joined(far, {"--truth", "field"}));
  double rmse = 0;
  for (const char* seed : {"1", "2", "3"}) {
    w.render("picture.exr", joined(far, {"--error", "field", "--error-pixels", "400", "--error-seed", seed,
                                         "--stats", w / "stats.json"}));
    const json error = json::parse(read_text(w / "stats.json")).at(0).at("error");
    rmse = rmse_of(w, "picture.exr", "field.exr");
    CHECK(error.at("rmse_low").get<double>() <= rmse * 1.0001);
    CHECK(error.at("rmse_high").get<double>() >= rmse * 0.9999);
    // The bounds hold fewer pixels than the limit of evaluations.
    CHECK(error.at("pixels") < 400);
    CHECK(error.at("rmse").get<double>() == Approx(rmse).epsilon(1e-4));
  }
  CHECK(rmse > 0);
}
