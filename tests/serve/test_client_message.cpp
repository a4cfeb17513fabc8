#include "serve/client_message.hpp"

#include <nlohmann/json.hpp>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

MessageRules rules() {
  MessageRules r;
  r.initial.shown.transfer_function = {
      .name = "ramp", .colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}}, .opacities = {{0, 0}, {1, 1}}};
  r.grid.dims = {10, 20, 30};
  r.frames = 4;
  return r;
}

template <class Message>
Message parsed(const std::string& text) {
  return std::get<Message>(parse_client_message(text, rules()));
}

}  // namespace

TEST_CASE("A view's missing members are those of the initial scene") {
  const auto view = parsed<ViewMessage>(
      R"({"type":"view","seq":7,"moving":true,"width":640,"height":480,"time":12.5,"state":{"camera":{"azimuth":30}}})");
  CHECK(view.seq == 7);
  CHECK(view.moving);
  CHECK(view.scene.shown.width == 640);
  CHECK(view.scene.shown.height == 480);
  CHECK(view.time == 12.5);
  SceneState expected = rules().initial;
  expected.shown.camera.azimuth = 30;
  expected.shown.width = 640;
  expected.shown.height = 480;
  CHECK(view.scene == expected);
}

TEST_CASE("A scene that was written is read back to the last bit") {
  SceneState scene = rules().initial;
  scene.shown.camera = {
      .azimuth = 0.1, .elevation = -20, .roll = 3, .zoom = 1.7, .fov = 30, .distance = 4, .pan = {0.1, 0.2}};
  scene.shown.transfer_function.name = "mine";
  scene.shown.transfer_function.opacities = {{-3, 0.25}, {0.1, 0}, {0.1, 1}};
  scene.shown.shading = Shading::none;
  scene.shown.mode = Mode::surface;
  scene.shown.isovalue = 0.1;
  scene.shown.light = {1, 2, 3};
  scene.frame = 3;
  scene.shown.clip = VoxelBox{{1, 2, 3}, {4, 20, 30}};
  scene.shown.clip_planes = {{{1, 0, -2}, 3.5}, {{0, 1, 0}, 0}};
  scene.background = {0.1, 0.2, 0.3};
  CHECK(scene_from(nlohmann::json::parse(text_of(to_json(scene))), rules()) == scene);
}

TEST_CASE("Channels are as many as the volume has, and are read back to the last bit") {
  MessageRules two = rules();
  two.initial.channels = {{true, {1, 0, 1}, {0, 1}}, {true, {0, 1, 0}, {0, 1}}};
  SceneState scene = two.initial;
  scene.channels = {{false, {0.1, 0.2, 0.3}, {-0.1, 1e9}}, {true, {1, 1, 1}, {7, 7}}};
  CHECK(scene_from(nlohmann::json::parse(text_of(to_json(scene))), two) == scene);
  CHECK(scene_from(nlohmann::json::object(), two) == two.initial);
  for (const char* channels : {R"([])", R"(7)", R"([{}, {}])", R"([7, 7])",
                               R"([{"visible": true, "colour": [0, 0, 0], "window": [0, 1]}])",
                               R"([{"visible": true, "colour": [0, 0, 0], "window": [0, 1]},
                                   {"visible": true, "colour": [0, 0, 0], "window": [2, 1]}])",
                               R"([{"visible": true, "colour": [0, 0, 0], "window": [0, 1]},
                                   {"visible": true, "colour": [0, 0, 2], "window": [0, 1]}])"})
    CHECK_THROWS_AS(scene_from({{"channels", nlohmann::json::parse(channels)}}, two), InputError);
}

TEST_CASE("Messages that are not quite right are refused with words") {
  for (
      const char* text :
      {"",
       "{",
       "[]",
       "{}",
       R"({"type":"video"})",
       R"({"type":["view"]})",
       R"({"type":"ack","picture":-1})",
       R"({"type":"ack","picture":4294967296})",
       R"({"type":"view","seq":1,"width":0,"height":9})",
       R"({"type":"view","seq":1,"width":64.5,"height":9})",
       R"({"type":"view","seq":1,"width":4097,"height":9})",
       R"({"type":"view","seq":1,"width":9})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"camera":{"zoom":1e400}}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"camera":{"zoom":"1"}}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"camera":{"pan":[1]}}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"clip":[[0,11],[0,20],[0,30]]}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"clip":[[3,3],[0,20],[0,30]]}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"clip_planes":[[1,0,0]]}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"clip_planes":[[1,0,0,0],[1,0,0,0],[1,0,0,0]]}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"transfer_function":{"opacities":[[0,2],[1,1]]}}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"transfer_function":{"colours":[[0,0,0,0]]}}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"mode":"x"}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"isovalue":"1"}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"frame":4}})",
       R"({"type":"view","seq":1,"width":9,"height":9,"state":{"frame":-1}})",
       R"({"type":"snapshot","id":1,"width":9,"height":9,"format":"jpg"})",
       R"({"type":"probe","id":1,"x":-1,"y":0})"})
    CHECK_THROWS_AS(parse_client_message(text, rules()), InputError);
}

TEST_CASE("Deep nesting is refused before it is parsed, brackets in texts do not count") {
  CHECK_THROWS_AS(parse_client_message(std::string(60000, '['), rules()), InputError);
  CHECK_THROWS_AS(parse_client_message(R"({"type":"drive","a":[[[[[[[[0]]]]]]]]})", rules()), InputError);
  CHECK_NOTHROW(parse_client_message(R"({"type":"drive","a":"[[[[[[[[[[\"[[[["})", rules()));
}

TEST_CASE("A movie's frame says which it is, and what all have in common") {
  const auto frame = parsed<FileMessage>(
      R"({"type":"movie_frame","id":3,"index":4,"count":5,"fps":29.97,"width":64,"height":48,"state":{"camera":{"azimuth":30}}})");
  CHECK(frame.id == 3);
  REQUIRE(frame.movie);
  CHECK(frame.movie->index == 4);
  CHECK(frame.movie->plan == MoviePlan{5, 29.97, 64, 48});
  CHECK(frame.scene.shown.width == 64);
  CHECK(frame.scene.shown.height == 48);
  CHECK(frame.scene.shown.camera.azimuth == 30);
  for (const char* text :
       {R"({"type":"movie_frame","id":3,"index":5,"count":5,"fps":25,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":-1,"count":5,"fps":25,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":0,"count":0,"fps":25,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":0,"count":10001,"fps":25,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":0,"count":5,"fps":0.5,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":0,"count":5,"fps":121,"width":64,"height":48})",
        R"({"type":"movie_frame","id":3,"index":0,"count":5,"fps":25,"width":64,"height":5000})",
        R"({"type":"movie_frame","index":0,"count":5,"fps":25,"width":64,"height":48})",
        R"({"type":"snapshot","id":3,"format":"png","width":64,"height":48,"ruler":[[0,0,0],[1,0,0],[2,0,0],[3,0,0]]})",
        R"({"type":"snapshot","id":3,"format":"png","width":64,"height":48,"ruler":[[0,0]]})",
        R"({"type":"cancel"})"})
    CHECK_THROWS_AS(parse_client_message(text, rules()), InputError);
}

TEST_CASE("ParaView's map becomes a transfer function in few digits") {
  const auto message = parsed<MapMessage>(
      R"({"type":"map","id":7,"map":[{"Points":[0,0,0.25,1,8,1,0.5,0],"RGBPoints":[0,0,0,0.1234567891,8,1,1,1]}]})");
  CHECK(message.id == 7);
  const TransferFunction& tf = message.transfer_function;
  CHECK(tf.opacities == std::vector<TransferFunction::OpacityPoint>{{0, 0}, {2, 0}, {2, 1}, {8, 1}});
  CHECK(tf.colours.front().srgb.z == 0.123457);
  CHECK_THROWS_WITH(parsed<MapMessage>(R"({"type":"map","id":7,"map":{}})"),
                    Catch::Matchers::Contains("RGBPoints"));
  std::string many = R"({"type":"map","id":7,"map":{"ColorSpace":"Lab","RGBPoints":[0,0,0,0)";
  for (int k = 1; k < 40; ++k) many += "," + std::to_string(k) + ",1,1,1";
  CHECK_THROWS_WITH(parsed<MapMessage>(many + "]}}"), Catch::Matchers::Contains("colours"));
}

TEST_CASE("A wrong message still tells its number") {
  CHECK(id_of(R"({"type":"snapshot","id":4294967295,"format":"gif"})") == 4294967295);
  CHECK(id_of(R"({"type":["probe"],"id":0})") == 0U);
  for (const char* text : {"", "[]", "{}", R"({"id":-1})", R"({"id":1.5})", R"({"id":"1"})",
                           R"({"id":4294967296})", R"({"id":1,"a":[[[[[[[[0]]]]]]]]})"})
    CHECK_FALSE(id_of(text));
}

TEST_CASE("Texts from outside are written as JSON whatever bytes they have") {
  SceneState scene = rules().initial;
  scene.shown.transfer_function.name = std::string("\xff\"");
  CHECK(nlohmann::json::accept(text_of(to_json(scene))));
}
