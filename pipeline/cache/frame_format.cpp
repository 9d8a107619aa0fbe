#include "pipeline/cache/frame_format.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace wry::pipeline {

namespace {

constexpr std::int64_t VERSION = 2;
constexpr std::size_t MOST_COMPONENTS = 1'000'000;
constexpr std::array<std::pair<ChannelOn, const char*>, 4> CHANNEL_ON_NAMES = {{{ChannelOn::vertex, "vertex"},
                                                                                {ChannelOn::tet, "tet"},
                                                                                {ChannelOn::particle, "particle"},
                                                                                {ChannelOn::global, "global"}}};

std::string body_path(std::size_t index) {
  return fmt::format("/bodies/{:04}", index);
}

void write_header(Hdf5ImageWriter& file, const std::string& kind, const std::string& key) {
  file.attribute("/", "format", kind);
  file.attribute("/", "version", VERSION);
  file.attribute("/", "key", key);
}

void check_header(Hdf5ImageReader& file, const std::string& kind) {
  const std::string format = file.text("/", "format");
  const std::int64_t version = file.integer("/", "version");
  if (format != kind || version != VERSION)
    file.refuse("/", fmt::format("is a '{}' of version {}, expected a '{}' of version {}; run again with --fresh",
                                 format, version, kind, VERSION));
}

std::string on_name(ChannelOn on) {
  for (const auto& [value, text] : CHANNEL_ON_NAMES) {
    if (value == on)
      return text;
  }
  return {};
}

std::optional<ChannelOn> parse_on(const std::string& name) {
  for (const auto& [value, text] : CHANNEL_ON_NAMES) {
    if (name == text)
      return value;
  }
  return std::nullopt;
}

Status write_channel(Hdf5ImageWriter& file, const std::string& body, const Channel& channel) {
  const std::size_t components = static_cast<std::size_t>(channel.components);
  if (channel.name.empty() || channel.name.find_first_of("/.") != std::string::npos)
    return make_error(ErrorCode::bad_input, "'{}' cannot be the name of a channel: it is empty or has a slash or a dot",
                      channel.name);
  if (channel.components < 1 || channel.values.size() % components != 0)
    return make_error(ErrorCode::bad_input, "channel {}: {} values are no whole rows of {} components", channel.name,
                      channel.values.size(), channel.components);
  const std::string path = body + "/" + channel.name;
  const ArrayType type = channel.storage == ChannelStorage::float64 ? ArrayType::float64 : ArrayType::float32;
  file.array(path, {channel.values.size() / components, components}, channel.values, type);
  file.attribute(path, "on", on_name(channel.on));
  return {};
}

Channel read_channel(Hdf5ImageReader& file, const std::string& body, const std::string& name) {
  const std::string path = body + "/" + name;
  const ArrayFacts facts = file.facts(path);
  const std::optional<ChannelOn> rows_of = parse_on(file.text(path, "on"));
  if (!rows_of || facts.shape.size() != 2 || facts.shape[1] < 1 || facts.shape[1] > MOST_COMPONENTS) {
    file.refuse(path, "is no channel");
    return {};
  }
  Channel channel;
  channel.name = name;
  channel.on = *rows_of;
  channel.components = static_cast<int>(facts.shape[1]);
  channel.storage = facts.type == ArrayType::float64 ? ChannelStorage::float64 : ChannelStorage::float32;
  channel.values = file.doubles(path);
  return channel;
}

FrameBody read_frame_body(Hdf5ImageReader& file, const std::string& path) {
  FrameBody body;
  body.name = file.text(path, "name");
  const std::vector<double> transform = file.doubles(path + "/transform");
  if (transform.size() == 16)
    std::copy(transform.begin(), transform.end(), body.transform.data());
  else
    file.refuse(path + "/transform", "is not 4 x 4");
  for (const std::string& member : file.members(path + "/channels"))
    body.channels.push_back(read_channel(file, path + "/channels", member));
  return body;
}

template <class Rows> std::span<const typename Rows::Scalar> flat(const Rows& rows) {
  return {rows.data(), static_cast<std::size_t>(rows.size())};
}

template <class Rows> void write_rows(Hdf5ImageWriter& file, const std::string& path, const Rows& rows) {
  const std::vector<std::size_t> shape = {static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols())};
  if constexpr (std::is_same_v<typename Rows::Scalar, double>)
    file.array(path, shape, flat(rows), ArrayType::float64);
  else
    file.array(path, shape, flat(rows));
}

template <class Rows> void read_rows(Hdf5ImageReader& file, const std::string& path, Rows& rows) {
  const ArrayFacts facts = file.facts(path);
  if (facts.shape.size() != 2 || facts.shape[1] != static_cast<std::size_t>(Rows::ColsAtCompileTime)) {
    file.refuse(path, fmt::format("has not {} columns", static_cast<int>(Rows::ColsAtCompileTime)));
    return;
  }
  const auto take = [&rows](const auto& values) {
    rows.resize(static_cast<Eigen::Index>(values.size()) / Rows::ColsAtCompileTime, Rows::ColsAtCompileTime);
    std::copy(values.begin(), values.end(), rows.data());
  };
  if constexpr (std::is_same_v<typename Rows::Scalar, double>)
    take(file.doubles(path));
  else
    take(file.integers(path));
}

void write_grain(Hdf5ImageWriter& file, const std::string& path, const Grain& grain) {
  file.attribute(path, "grain_shape", static_cast<std::int64_t>(grain.shape));
  file.attribute(path, "grain_size_x", grain.size.x());
  file.attribute(path, "grain_size_y", grain.size.y());
  file.attribute(path, "grain_size_z", grain.size.z());
}

void read_grain(Hdf5ImageReader& file, const std::string& path, SceneBody& body) {
  const std::int64_t kind = file.integer(path, "kind");
  const std::int64_t shape = file.integer(path, "grain_shape");
  if (kind < 0 || kind > static_cast<int>(BodyKind::particles) || shape < 0 ||
      shape > static_cast<int>(GrainShape::mesh)) {
    file.refuse(path, "is of a kind that this build does not know");
    return;
  }
  body.kind = static_cast<BodyKind>(kind);
  body.grain.shape = static_cast<GrainShape>(shape);
  body.grain.size =
      Vec3(file.number(path, "grain_size_x"), file.number(path, "grain_size_y"), file.number(path, "grain_size_z"));
}

SceneBody read_static_body(Hdf5ImageReader& file, const std::string& path) {
  SceneBody body;
  body.name = file.text(path, "name");
  body.look = file.text(path, "look");
  body.simulated = file.integer(path, "simulated") != 0;
  read_grain(file, path, body);
  read_rows(file, path + "/rest_positions", body.rest_positions);
  read_rows(file, path + "/tets", body.tets);
  read_rows(file, path + "/triangles", body.triangles);
  return body;
}

/// What was read, unless something about the file was wrong.
template <class T> Result<T> whole(const Hdf5ImageReader& file, T value) {
  if (Status status = file.status(); !status)
    return status.error();
  return value;
}

} // namespace

Result<std::string> encode_frame(const Frame& frame, const std::string& key, Compression compression) {
  Hdf5ImageWriter file(compression);
  write_header(file, "wry frame", key);
  file.attribute("/", "number", static_cast<std::int64_t>(frame.number));
  file.attribute("/", "time", frame.time);
  file.group("/bodies");
  for (std::size_t i = 0; i < frame.bodies.size(); ++i) {
    const FrameBody& body = frame.bodies[i];
    file.group(body_path(i));
    file.attribute(body_path(i), "name", body.name);
    file.array(body_path(i) + "/transform", {4, 4}, flat(body.transform), ArrayType::float64);
    file.group(body_path(i) + "/channels");
    for (const Channel& channel : body.channels) {
      if (Status written = write_channel(file, body_path(i) + "/channels", channel); !written)
        return make_error(written.error().code, "frame {}, body {}: {}", frame.number, body.name,
                          written.error().message);
    }
  }
  return file.finish();
}

Result<Frame> decode_frame(std::string bytes, const std::string& name) {
  Hdf5ImageReader file(std::move(bytes), name);
  check_header(file, "wry frame");
  Frame frame;
  frame.number = static_cast<int>(file.integer("/", "number"));
  frame.time = file.number("/", "time");
  for (const std::string& member : file.members("/bodies"))
    frame.bodies.push_back(read_frame_body(file, "/bodies/" + member));
  return whole(file, std::move(frame));
}

Result<std::string> encode_static(const SceneStatic& scene, const std::string& key, Compression compression) {
  Hdf5ImageWriter file(compression);
  write_header(file, "wry static scene", key);
  file.group("/bodies");
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    file.group(body_path(i));
    file.attribute(body_path(i), "name", body.name);
    file.attribute(body_path(i), "look", body.look);
    file.attribute(body_path(i), "simulated", std::int64_t(body.simulated ? 1 : 0));
    file.attribute(body_path(i), "kind", static_cast<std::int64_t>(body.kind));
    write_grain(file, body_path(i), body.grain);
    write_rows(file, body_path(i) + "/rest_positions", body.rest_positions);
    write_rows(file, body_path(i) + "/tets", body.tets);
    write_rows(file, body_path(i) + "/triangles", body.triangles);
  }
  return file.finish();
}

Result<SceneStatic> decode_static(std::string bytes, const std::string& name) {
  Hdf5ImageReader file(std::move(bytes), name);
  check_header(file, "wry static scene");
  SceneStatic scene;
  for (const std::string& member : file.members("/bodies"))
    scene.bodies.push_back(read_static_body(file, "/bodies/" + member));
  return whole(file, std::move(scene));
}

Result<std::string> encode_checkpoint(const Checkpoint& checkpoint, const std::string& key) {
  Hdf5ImageWriter file(Compression::none);
  write_header(file, "wry checkpoint", key);
  file.attribute("/", "frame", static_cast<std::int64_t>(checkpoint.frame));
  file.attribute("/", "time", checkpoint.time);
  file.group("/arrays");
  for (std::size_t i = 0; i < checkpoint.state.size(); ++i) {
    const NamedArray& array = checkpoint.state[i];
    const std::string path = fmt::format("/arrays/{:04}", i);
    file.array(path, array.shape, array.values, ArrayType::float64);
    file.attribute(path, "name", array.name);
  }
  return file.finish();
}

namespace {

ArrayType narrowest(const std::vector<double>& values) {
  const bool fits = std::all_of(values.begin(), values.end(),
                                [](double v) { return static_cast<double>(static_cast<float>(v)) == v; });
  return fits ? ArrayType::float32 : ArrayType::float64;
}

} // namespace

Result<std::string> encode_fields(const StateArchive& fields, const std::string& key) {
  Hdf5ImageWriter file(Compression::none);
  write_header(file, "wry fields", key);
  file.group("/arrays");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string path = fmt::format("/arrays/{:04}", i);
    file.array(path, fields[i].shape, fields[i].values, narrowest(fields[i].values));
    file.attribute(path, "name", fields[i].name);
  }
  return file.finish();
}

Result<StateArchive> decode_fields(std::string bytes, const std::string& name) {
  Hdf5ImageReader file(std::move(bytes), name);
  check_header(file, "wry fields");
  StateArchive fields;
  for (const std::string& member : file.members("/arrays")) {
    const std::string path = "/arrays/" + member;
    fields.push_back(NamedArray{file.text(path, "name"), file.facts(path).shape, file.doubles(path)});
  }
  return whole(file, std::move(fields));
}

Result<Checkpoint> decode_checkpoint(std::string bytes, const std::string& name) {
  Hdf5ImageReader file(std::move(bytes), name);
  check_header(file, "wry checkpoint");
  Checkpoint checkpoint;
  checkpoint.frame = static_cast<int>(file.integer("/", "frame"));
  checkpoint.time = file.number("/", "time");
  for (const std::string& member : file.members("/arrays")) {
    const std::string path = "/arrays/" + member;
    checkpoint.state.push_back(NamedArray{file.text(path, "name"), file.facts(path).shape, file.doubles(path)});
  }
  return whole(file, std::move(checkpoint));
}

} // namespace wry::pipeline
