#include "sim/geometry/msh_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include <Eigen/Geometry>

#include "sim/geometry/msh_import_text.h"

namespace wry::geometry {

namespace {

// Gmsh's numbers of element types.
constexpr int TET = 4;
constexpr int SECOND_ORDER_TET = 11;
// Points, lines and faces of any order, which bound what we want.
constexpr std::array LOWER_DIMENSIONAL = {1,  2,  3,  8,  9,  10, 15, 16, 20, 21, 22,
                                          23, 24, 25, 26, 27, 28, 36, 37, 38, 62};

struct Node {
  std::int64_t tag;
  std::size_t line;
  Vec3 position;
};

struct TetEntry {
  std::array<std::int64_t, 4> tags;
  std::size_t line;
};

class Parser {
public:
  explicit Parser(std::string_view text)
      : m_text(text) {}

  Result<MshMesh> parse() {
    if (Status status = parse_sections(); !status)
      return status.error();
    if (m_tets.empty())
      return make_error(ErrorCode::bad_input, "there are {} nodes, but no tets; mesh the volume (gmsh -3)",
                        m_nodes.size());
    if (Status status = sort_nodes(); !status)
      return status.error();
    return assemble();
  }

private:
  Status parse_sections() {
    if (!m_text.next_line() || m_text.line() != "$MeshFormat")
      return make_error(ErrorCode::bad_input, "line 1: a Gmsh file begins with $MeshFormat");
    if (Status status = parse_format(); !status)
      return status;
    while (m_text.next_line()) {
      const std::string section(m_text.line());
      if (section.empty() || section[0] != '$')
        return m_text.error("a section should begin here, with a $");
      Status status;
      if (section == "$Nodes")
        status = m_is_new ? parse_nodes_41() : parse_nodes_22();
      else if (section == "$Elements")
        status = m_is_new ? parse_elements_41() : parse_elements_22();
      else
        status = skip_section(section);
      if (!status)
        return status;
    }
    return {};
  }

  Status next_line(const char* section) {
    if (!m_text.next_line())
      return make_error(ErrorCode::bad_input, "line {}: the file ends within {}: it is cut short", m_text.number(),
                        section);
    return {};
  }

  Status expect(std::string_view end) {
    if (Status status = next_line("a section"); !status)
      return status;
    if (m_text.line() != end)
      return m_text.error(fmt::format("{} should stand here", end));
    return {};
  }

  Status skip_section(const std::string& section) {
    const std::string end = "$End" + section.substr(1);
    while (m_text.next_line())
      if (m_text.line() == end)
        return {};
    return make_error(ErrorCode::bad_input, "the file ends within {}: it is cut short", MshText::printable(section));
  }

  Status parse_format() {
    if (Status status = next_line("$MeshFormat"); !status)
      return status;
    const Result<double> version = m_text.take<double>("the version");
    const Result<int> is_binary = version ? m_text.take<int>("the file type") : Result<int>(version.error());
    if (!is_binary)
      return is_binary.error();
    m_is_new = *version == 4.1;
    if (!m_is_new && *version != 2.2)
      return m_text.error(fmt::format("version {} is not read; save as 2.2 or 4.1 (gmsh -format msh41)", *version));
    if (*is_binary != 0)
      return m_text.error("binary files are not read; save as ASCII");
    return expect("$EndMeshFormat");
  }

  Status take_position(std::int64_t tag, std::size_t line) {
    Vec3 position;
    for (int i = 0; i < 3; ++i) {
      const Result<double> value = m_text.take<double>("a coordinate");
      if (!value)
        return value.error();
      position[i] = *value;
    }
    if (!position.allFinite())
      return m_text.error(fmt::format("the position of node {} is not finite", tag));
    m_nodes.push_back({tag, line, position});
    return {};
  }

  Status parse_nodes_22() {
    if (Status status = next_line("$Nodes"); !status)
      return status;
    const Result<std::uint64_t> count = m_text.take<std::uint64_t>("the number of nodes");
    if (!count)
      return count.error();
    if (Status status = m_text.check_lines(*count, "nodes"); !status)
      return status;
    for (std::uint64_t i = 0; i < *count; ++i) {
      if (Status status = next_line("$Nodes"); !status)
        return status;
      const Result<std::int64_t> tag = m_text.take<std::int64_t>("a node's number");
      if (!tag)
        return tag.error();
      if (Status status = take_position(*tag, m_text.number()); !status)
        return status;
    }
    return expect("$EndNodes");
  }

  // The four counts at the head of a 4.1 section; only the number of blocks matters.
  Result<std::uint64_t> take_blocks(const char* section) {
    if (Status status = next_line(section); !status)
      return status.error();
    const Result<std::uint64_t> blocks = m_text.take<std::uint64_t>("the number of blocks");
    if (!blocks)
      return blocks.error();
    if (Status status = m_text.check_lines(*blocks, "blocks"); !status)
      return status.error();
    return blocks;
  }

  struct Block {
    int dimension;
    std::int64_t entity;
    int kind; // parametric or not; or the type of elements
    std::uint64_t count;
  };

  Result<Block> take_block(const char* section) {
    if (Status status = next_line(section); !status)
      return status.error();
    const Result<int> dimension = m_text.take<int>("the dimension of a block");
    if (!dimension)
      return dimension.error();
    const Result<std::int64_t> entity = m_text.take<std::int64_t>("the entity of a block");
    if (!entity)
      return entity.error();
    const Result<int> kind = m_text.take<int>("the kind of a block");
    if (!kind)
      return kind.error();
    const Result<std::uint64_t> count = m_text.take<std::uint64_t>("the size of a block");
    if (!count)
      return count.error();
    if (Status status = m_text.check_lines(*count, "lines"); !status)
      return status.error();
    return Block{*dimension, *entity, *kind, *count};
  }

  Status parse_nodes_41() {
    const Result<std::uint64_t> blocks = take_blocks("$Nodes");
    if (!blocks)
      return blocks.error();
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const Result<Block> block = take_block("$Nodes");
      if (!block)
        return block.error();
      std::vector<std::pair<std::int64_t, std::size_t>> tags;
      for (std::uint64_t i = 0; i < block->count; ++i) {
        if (Status status = next_line("$Nodes"); !status)
          return status;
        const Result<std::int64_t> tag = m_text.take<std::int64_t>("a node's number");
        if (!tag)
          return tag.error();
        if (!m_text.line_is_done())
          return m_text.error("a node's number should stand alone on its line");
        tags.emplace_back(*tag, m_text.number());
      }
      for (const auto& [tag, line] : tags) {
        if (Status status = next_line("$Nodes"); !status)
          return status;
        if (Status status = take_position(tag, line); !status)
          return status;
      }
    }
    return expect("$EndNodes");
  }

  // The corners of an element of this type on the rest of this line; nothing for points, lines and faces.
  Status take_element(int type) {
    if (std::find(LOWER_DIMENSIONAL.begin(), LOWER_DIMENSIONAL.end(), type) != LOWER_DIMENSIONAL.end())
      return {};
    if (type != TET && type != SECOND_ORDER_TET)
      return m_text.error(fmt::format("elements of type {} are not tets; mesh the volume with tets only", type));
    TetEntry entry{{}, m_text.number()};
    for (int i = 0; i < (type == TET ? 4 : 10); ++i) {
      const Result<std::int64_t> tag = m_text.take<std::int64_t>("a node of a tet");
      if (!tag)
        return tag.error();
      if (i < 4)
        entry.tags[i] = *tag;
    }
    if (!m_text.line_is_done())
      return m_text.error("there are too many nodes for a tet");
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        if (entry.tags[i] == entry.tags[j])
          return m_text.error(fmt::format("the tet names node {} twice", entry.tags[i]));
    m_second_order += type == SECOND_ORDER_TET;
    m_tets.push_back(entry);
    return {};
  }

  Status parse_elements_22() {
    if (Status status = next_line("$Elements"); !status)
      return status;
    const Result<std::uint64_t> count = m_text.take<std::uint64_t>("the number of elements");
    if (!count)
      return count.error();
    if (Status status = m_text.check_lines(*count, "elements"); !status)
      return status;
    for (std::uint64_t i = 0; i < *count; ++i) {
      if (Status status = next_line("$Elements"); !status)
        return status;
      if (Result<std::int64_t> tag = m_text.take<std::int64_t>("an element's number"); !tag)
        return tag.error();
      const Result<int> type = m_text.take<int>("an element's type");
      const Result<int> labels = type ? m_text.take<int>("the number of tags") : Result<int>(type.error());
      if (!labels)
        return labels.error();
      for (int k = 0; k < *labels; ++k)
        if (Result<std::int64_t> label = m_text.take<std::int64_t>("a tag"); !label)
          return label.error();
      if (Status status = take_element(*type); !status)
        return status;
    }
    return expect("$EndElements");
  }

  Status parse_elements_41() {
    const Result<std::uint64_t> blocks = take_blocks("$Elements");
    if (!blocks)
      return blocks.error();
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const Result<Block> block = take_block("$Elements");
      if (!block)
        return block.error();
      for (std::uint64_t i = 0; i < block->count; ++i) {
        if (Status status = next_line("$Elements"); !status)
          return status;
        if (Result<std::int64_t> tag = m_text.take<std::int64_t>("an element's number"); !tag)
          return tag.error();
        if (Status status = take_element(block->kind); !status)
          return status;
      }
    }
    return expect("$EndElements");
  }

  Status sort_nodes() {
    constexpr std::size_t MAX_ROWS = std::numeric_limits<std::int32_t>::max() / 4;
    if (m_nodes.size() > MAX_ROWS || m_tets.size() > MAX_ROWS)
      return make_error(ErrorCode::bad_input, "{} nodes and {} tets are too many", m_nodes.size(), m_tets.size());
    m_order.resize(m_nodes.size());
    for (std::size_t i = 0; i < m_order.size(); ++i)
      m_order[i] = static_cast<std::int32_t>(i);
    std::sort(m_order.begin(), m_order.end(), [&](std::int32_t a, std::int32_t b) {
      return m_nodes[a].tag != m_nodes[b].tag ? m_nodes[a].tag < m_nodes[b].tag : a < b;
    });
    for (std::size_t i = 1; i < m_order.size(); ++i) {
      const Node& node = m_nodes[m_order[i]];
      const Node& before = m_nodes[m_order[i - 1]];
      if (node.tag == before.tag)
        return make_error(ErrorCode::bad_input, "line {}: node {} is there already, on line {}", node.line, node.tag,
                          before.line);
    }
    return {};
  }

  // Place in m_nodes; -1: there is none.
  std::int32_t find_node(std::int64_t tag) const {
    const auto found = std::lower_bound(m_order.begin(), m_order.end(), tag,
                                        [&](std::int32_t i, std::int64_t wanted) { return m_nodes[i].tag < wanted; });
    return found != m_order.end() && m_nodes[*found].tag == tag ? *found : -1;
  }

  Result<MshMesh> assemble() const {
    MshMesh result;
    result.second_order_tets = m_second_order;
    std::vector<std::array<std::int32_t, 4>> tets;
    std::vector<char> used(m_nodes.size(), 0);
    for (const TetEntry& entry : m_tets) {
      std::array<std::int32_t, 4> tet{};
      for (int k = 0; k < 4; ++k) {
        tet[k] = find_node(entry.tags[k]);
        if (tet[k] < 0)
          return make_error(ErrorCode::bad_input, "line {}: the tet names node {}, which is not there", entry.line,
                            entry.tags[k]);
        used[tet[k]] = 1;
      }
      const Status status = orient(entry, tet, result);
      if (!status)
        return status.error();
      tets.push_back(tet);
    }
    if (Status status = check_faces(tets); !status)
      return status.error();
    std::vector<std::int32_t> new_index(m_nodes.size(), -1);
    std::int32_t count = 0;
    for (std::size_t i = 0; i < m_nodes.size(); ++i)
      if (used[i])
        new_index[i] = count++;
    result.unused_vertices = static_cast<std::int64_t>(m_nodes.size()) - count;
    result.mesh.vertices.resize(count, 3);
    for (std::size_t i = 0; i < m_nodes.size(); ++i)
      if (used[i])
        result.mesh.vertices.row(new_index[i]) = m_nodes[i].position.transpose();
    result.mesh.tets.resize(static_cast<Eigen::Index>(tets.size()), 4);
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (int k = 0; k < 4; ++k)
        result.mesh.tets(static_cast<Eigen::Index>(t), k) = new_index[tets[t][k]];
    return result;
  }

  Status orient(const TetEntry& entry, std::array<std::int32_t, 4>& tet, MshMesh& result) const {
    const Vec3& origin = m_nodes[tet[0]].position;
    const Vec3 a = m_nodes[tet[1]].position - origin;
    const Vec3 b = m_nodes[tet[2]].position - origin;
    const Vec3 c = m_nodes[tet[3]].position - origin;
    const double six_volumes = a.cross(b).dot(c);
    const double longest = std::max({a.norm(), b.norm(), c.norm()});
    // Slivers are for the quality gate to judge; this is about tets that have no volume beyond round-off.
    if (!(std::abs(six_volumes) > 1e-14 * longest * longest * longest))
      return make_error(ErrorCode::bad_input, "line {}: the tet of nodes {}, {}, {}, {} has no volume ({:.3g} m^3)",
                        entry.line, entry.tags[0], entry.tags[1], entry.tags[2], entry.tags[3], six_volumes / 6);
    if (six_volumes < 0) {
      std::swap(tet[2], tet[3]);
      ++result.turned_tets;
    }
    return {};
  }

  // No face may belong to more than two tets.
  Status check_faces(const std::vector<std::array<std::int32_t, 4>>& tets) const {
    struct Face {
      std::array<std::int32_t, 3> corners;
      std::int32_t tet;
    };
    std::vector<Face> faces;
    faces.reserve(tets.size() * 4);
    for (std::size_t t = 0; t < tets.size(); ++t) {
      for (int skipped = 0; skipped < 4; ++skipped) {
        std::array<std::int32_t, 3> corners{};
        int count = 0;
        for (int k = 0; k < 4; ++k)
          if (k != skipped)
            corners[count++] = tets[t][k];
        std::sort(corners.begin(), corners.end());
        faces.push_back({corners, static_cast<std::int32_t>(t)});
      }
    }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
      return a.corners != b.corners ? a.corners < b.corners : a.tet < b.tet;
    });
    for (std::size_t i = 2; i < faces.size(); ++i)
      if (faces[i].corners == faces[i - 2].corners)
        return make_error(ErrorCode::bad_input,
                          "line {}: a face of this tet belongs to two others already, on lines {} and {}",
                          m_tets[faces[i].tet].line, m_tets[faces[i - 2].tet].line, m_tets[faces[i - 1].tet].line);
    return {};
  }

  MshText m_text;
  bool m_is_new = false;
  std::vector<Node> m_nodes;
  std::vector<TetEntry> m_tets;
  std::vector<std::int32_t> m_order;
  std::int64_t m_second_order = 0;
};

} // namespace

Result<MshMesh> parse_msh(std::string_view text) {
  return Parser(text).parse();
}

Result<MshMesh> read_msh(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return make_error(ErrorCode::missing_input, "cannot open {}", path);
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad() || text.fail())
    return make_error(ErrorCode::io, "cannot read {}", path);
  Result<MshMesh> mesh = parse_msh(text.view());
  if (!mesh)
    return Error{mesh.error().code, path + ": " + mesh.error().message};
  return mesh;
}

Result<TetMesh> import_tets(const std::string& path) {
  Result<MshMesh> msh = read_msh(path);
  if (!msh)
    return std::move(msh).error();
  return std::move(msh->mesh);
}

} // namespace wry::geometry
