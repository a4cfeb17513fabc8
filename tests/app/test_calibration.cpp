// Which views a calibration renders, and what it computes from given pictures and times.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <glm/vec3.hpp>
#include <map>

#include "app/program_runner.hpp"
#include "frame/frame_geometry.hpp"
#include "session/render.hpp"
#include "study/calibration.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::app;
using namespace ringsplat::test;

namespace {

constexpr int width = 64, height = 48;

FrameSpec frame_of_size() {
  FrameSpec frame{.how = Splats{}};
  frame.shown.width = width;
  frame.shown.height = height;
  return frame;
}

Traversal traversal_of(const Camera& camera, const Grid& grid) {
  const LatticeFrame lattice = lattice_frame(grid);
  return choose_traversal(make_view(camera, lattice, width, height), lattice);
}

/// A calibration of two settings and two views whose truth is empty: a picture is its own error.
class Bench {
 public:
  explicit Bench(std::size_t pixels) {
    const std::string volume = folder_ / "volume.nrrd";
    REQUIRE(app_test::run_program({"synth", "ball", "--dims", "8x8x8", "-o", volume}).code == 0);
    FrameSpec reference;
    reference.how = Sheets{};
    reference.shown.width = width;
    reference.shown.height = height;
    reference.shown.shading = Shading::none;
    reference.shown.transfer_function = constant_opacity(0);
    Shortcuts exact, coarse;
    coarse.undersample = 4;
    VolumeOptions options;
    options.path = volume;
    calibration_ =
        std::make_unique<Calibration>(reference, std::vector<Camera>{{.azimuth = 0}, {.azimuth = 30}},
                                      std::vector{exact, coarse}, options, ErrorOptions{{}, pixels, 1});
  }

  /// Answers every frame: `answer(coarse, oblique, n, result)` fills picture and seconds for the n-th time
  /// (from 0) that the view is drawn with the setting. The very first frame gets values that must not count.
  template <class Answer>
  std::vector<MeasuredShortcuts> measure(const Answer& answer) {
    const Director director = calibration_->director();
    std::map<std::pair<bool, bool>, int> times;
    for (bool first = true; const auto spec = director.next_frame(); first = false) {
      const bool coarse = spec->shown.reduction.factor == 4, oblique = spec->shown.camera.azimuth > 0;
      FrameResult result;
      result.spec = *spec;
      result.image = Image(width, height);
      if (first) {
        std::fill(result.image.rgba.begin(), result.image.rgba.end(), 1.0F);
        result.stats.seconds = 1000;
      } else {
        answer(coarse, oblique, times[{coarse, oblique}]++, result);
      }
      director.frame_done(std::move(result));
    }
    return calibration_->measured();
  }

 private:
  app_test::TemporaryFolder folder_;
  std::unique_ptr<Calibration> calibration_;
};

}  // namespace

TEST_CASE("a calibration looks at the run's straightest and most oblique view of each slice set") {
  const FrameSpec frame = frame_of_size();
  std::vector<Camera> run;
  for (const double lowest : {10.0, 60.0})
    for (double azimuth = 5; azimuth < 180; azimuth += 10)
      run.push_back({.azimuth = azimuth, .elevation = lowest + azimuth / 10, .zoom = 0.5 + azimuth / 100});
  for (const glm::dvec3& spacing : {glm::dvec3(1.0), glm::dvec3(1, 0.5, 2)}) {
    const Grid grid = make_grid({32, 30, 28}, ScalarType::uint8, spacing);
    const auto views = calibration_views(run, frame, grid);
    CHECK(views.size() == 6);
    std::map<Axis, std::vector<double>> all, chosen;
    for (const Camera& camera : run) {
      const Traversal t = traversal_of(camera, grid);
      all[t.axis].push_back(t.cos_angle);
    }
    for (const Camera& camera : views) {
      CHECK(std::find(run.begin(), run.end(), camera) != run.end());
      const Traversal t = traversal_of(camera, grid);
      chosen[t.axis].push_back(t.cos_angle);
    }
    for (auto& [axis, cosines] : all) {
      CHECK(std::ranges::min(chosen[axis]) == std::ranges::min(cosines));
      CHECK(std::ranges::max(chosen[axis]) == std::ranges::max(cosines));
    }
  }
}

TEST_CASE("a calibration of one view, or of equal ones, draws it once") {
  FrameSpec frame;
  frame.how = Sheets{};
  const Grid grid = make_grid({32, 30, 28});
  for (const Camera& camera :
       {Camera{.azimuth = 43, .elevation = 35}, Camera{.azimuth = 20, .fov = 30},
        Camera{.matrix = std::array<double, 12>{1, 0, 0, 9, 0, 0, -1, 0, 0, 1, 0, 0}}}) {
    CHECK(calibration_views({camera}, frame, grid) == std::vector{camera});
    CHECK(calibration_views({camera, camera}, frame, grid) == std::vector{camera});
  }
}

TEST_CASE("a setting counts by its worst view, and its time is the mean of the views' medians") {
  Bench bench(width * height);  // every pixel: nothing is left to chance
  const auto measured = bench.measure([](bool coarse, bool oblique, int n, FrameResult& result) {
    const float error = (coarse ? 8.0F : 1.0F) * (oblique ? 1.0F : 0.25F) / 255;
    std::fill(result.image.rgba.begin(), result.image.rgba.end(), error);
    const double seconds[] = {900, 3, 2, 4};  // the median of three is 3
    result.stats.seconds = seconds[n / 2 % 4] * (coarse ? 1 : 10) * (oblique ? 3 : 1);
  });
  REQUIRE(measured.size() == 2);
  CHECK(measured[0].shortcuts.undersample == 1);
  CHECK(measured[1].shortcuts.undersample == 4);
  CHECK(measured[0].rmse == Approx(1).epsilon(1e-6));
  CHECK(measured[1].rmse == Approx(8).epsilon(1e-6));
  CHECK(measured[0].rmse_high == Approx(1).epsilon(1e-6));
  CHECK(measured[1].rmse_high == Approx(8).epsilon(1e-6));
  CHECK(measured[0].seconds == Approx((30 + 90) / 2.0));
  CHECK(measured[1].seconds == Approx((3 + 9) / 2.0));
}

TEST_CASE("a setting's error has an upper end above what its sample says, the worst view's") {
  Bench bench(400);
  const auto measured = bench.measure([](bool coarse, bool oblique, int, FrameResult& result) {
    // In the middle one pixel in three is wrong, so a sample's error depends on its pixels.
    const float error = (coarse ? 8.0F : 1.0F) * (oblique ? 0.25F : 1.0F) / 255;
    for (int y = 16; y < 32; ++y)
      for (int x = 20; x < 44; ++x)
        if ((x + y) % 3 == 0) std::fill_n(result.image.pixel(x, y), 4, error);
    result.stats.seconds = 1;
  });
  REQUIRE(measured.size() == 2);
  const double whole = std::sqrt(16 * 24 / 3.0 / (width * height));  // of the first setting's worst view
  for (const auto& [m, error] : {std::pair{measured[0], whole}, {measured[1], 8 * whole}}) {
    CHECK(m.rmse == Approx(error).epsilon(0.35));
    CHECK(m.rmse_high > 1.03 * m.rmse);
    CHECK(m.rmse_high < 2 * error);
  }
  // A budget between the error and its upper end is not kept.
  const double between = 0.5 * (measured[1].rmse + measured[1].rmse_high);
  CHECK_FALSE(cheapest_within(std::span(measured).subspan(1), between).has_value());
  CHECK(cheapest_within(std::span(measured).subspan(1), measured[1].rmse_high) == 0);
}
