#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"
#include "pipeline/report/plot_canvas.h"

namespace wry::pipeline {

namespace {

const char* attribute_type(int components) {
  return components == 1 ? "Scalar" : components == 3 ? "Vector" : components == 9 ? "Tensor" : "Matrix";
}

/// An array in a file of the cache.
std::string data_item(const std::string& file, const std::string& path, std::size_t rows, std::size_t columns,
                      const char* type, int bytes) {
  return fmt::format(
      "<DataItem Dimensions=\"{} {}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}:{}</DataItem>", rows,
      columns, type, bytes, escape_markup(file), path);
}

std::string channel_item(const Channel& channel, const std::string& file, const std::string& body) {
  const auto columns = static_cast<std::size_t>(channel.components);
  return data_item(file, body + "/channels/" + channel.name, channel.values.size() / columns, columns, "Float",
                   channel.storage == ChannelStorage::float64 ? 8 : 4);
}

/// One body on one frame; empty when the cache has no positions of it, as for colliders that move as a whole.
std::string grid(const SceneBody& body, const FrameBody& frame, const std::string& path, const std::string& frame_file,
                 const std::string& static_file) {
  const Channel* position = find_channel(frame, "position");
  if (position == nullptr)
    return {};
  const std::size_t points = position->values.size() / 3;
  std::string text = fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n", escape_markup(body.name));
  if (body.tets.rows() > 0)
    text +=
        fmt::format("<Topology TopologyType=\"Tetrahedron\" NumberOfElements=\"{}\">{}</Topology>\n", body.tets.rows(),
                    data_item(static_file, path + "/tets", static_cast<std::size_t>(body.tets.rows()), 4, "Int", 4));
  else if (is_mesh(body))
    text += fmt::format(
        "<Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n", body.triangles.rows(),
        data_item(static_file, path + "/triangles", static_cast<std::size_t>(body.triangles.rows()), 3, "Int", 4));
  else
    text +=
        fmt::format("<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\"/>\n", points);
  text += "<Geometry GeometryType=\"XYZ\">" + channel_item(*position, frame_file, path) + "</Geometry>\n";
  for (const Channel& channel : frame.channels) {
    if (channel.name == "position" || channel.on == ChannelOn::global || channel.components < 1)
      continue;
    text += fmt::format("<Attribute Name=\"{}\" Center=\"{}\" AttributeType=\"{}\">{}</Attribute>\n",
                        escape_markup(channel.name), channel.on == ChannelOn::tet ? "Cell" : "Node",
                        attribute_type(channel.components), channel_item(channel, frame_file, path));
  }
  return text + "</Grid>\n";
}

} // namespace

Status export_xdmf(const ExportJob& job) {
  const auto file_in_cache = [&](const std::string& name) {
    return std::filesystem::relative(job.frames_folder / name, job.folder).generic_string();
  };
  const std::string static_file = file_in_cache("static.h5");
  std::string text = "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
                     "<Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  const Status gathered = for_each_cached_frame(job, [&](const Frame& frame) -> Status {
    text += fmt::format("<Grid Name=\"frame {}\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time "
                        "Value=\"{}\"/>\n",
                        frame.number, frame.time);
    for (std::size_t b = 0; b < frame.bodies.size(); ++b)
      text += grid(job.cached_scene.bodies[b], frame.bodies[b], fmt::format("/bodies/{:04}", b),
                   file_in_cache(frame_file_name(frame.number)), static_file);
    text += "</Grid>\n";
    return {};
  });
  if (!gathered)
    return gathered;
  return write_file_atomically(job.folder / (export_name(job.name) + ".xdmf"), text + "</Grid>\n</Domain>\n</Xdmf>\n");
}

} // namespace wry::pipeline
