// Simplifies a mesh with CGAL: METHOD MESH.ply FACES RUNS OUT.ply, where METHOD is garland-heckbert or
// lindstrom-turk. Prints what it cost as all programs here do.

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/PLY.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Stops at so many faces: CGAL 5.5 counts edges only.
struct At_faces {
  const Mesh& mesh;
  std::size_t faces;

  template <typename Cost, typename Profile>
  bool operator()(const Cost&, const Profile&, std::size_t, std::size_t) const {
    return mesh.number_of_faces() <= faces;
  }
};

static double resident_mb(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(field, 0) == 0) return std::stod(line.substr(field.size())) * 1024 / 1e6;
  return 0;
}

static double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// As in CGAL's examples, where placements that turn a face over are refused.
static void simplify(Mesh& mesh, const std::string& method, std::size_t faces) {
  At_faces stop{mesh, faces};
  if (method == "garland-heckbert") {
    using Policies = simplification::GarlandHeckbert_plane_policies<Mesh, Kernel>;
    using Placement = simplification::Bounded_normal_change_placement<Policies::Get_placement>;
    Policies policies(mesh);
    simplification::edge_collapse(mesh, stop,
                                  CGAL::parameters::get_cost(policies.get_cost())
                                      .get_placement(Placement(policies.get_placement())));
  } else {
    using Placement =
        simplification::Bounded_normal_change_placement<simplification::LindstromTurk_placement<Mesh>>;
    simplification::edge_collapse(mesh, stop,
                                  CGAL::parameters::get_cost(simplification::LindstromTurk_cost<Mesh>())
                                      .get_placement(Placement()));
  }
}

int main(int count, char** arguments) {
  if (count != 6) return 2;
  const std::string method = arguments[1];
  if (method != "garland-heckbert" && method != "lindstrom-turk") return 2;
  Mesh input;
  if (!CGAL::IO::read_PLY(arguments[2], input)) return 1;

  std::vector<double> wall_s, cpu_s;
  double before_mb = 0, peak_mb = 0;
  Mesh mesh;
  const int runs = std::stoi(arguments[4]);
  for (int run = 0; run < runs; ++run) {
    mesh = input;
    std::ofstream("/proc/self/clear_refs") << 5;
    const double resident = resident_mb("VmRSS:");
    const auto started = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    simplify(mesh, method, std::stoul(arguments[3]));
    cpu_s.push_back(double(std::clock() - cpu) / CLOCKS_PER_SEC);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;
    wall_s.push_back(wall.count());
    if (run == 0) {
      before_mb = resident;
      peak_mb = resident_mb("VmHWM:") - resident;
    }
  }
  mesh.collect_garbage();
  std::ofstream out(arguments[5], std::ios::binary);
  CGAL::IO::set_binary_mode(out);
  if (!CGAL::IO::write_PLY(out, mesh)) return 1;
  std::printf("%.4f,%.4f,%.1f,%.1f\n", median(wall_s), median(cpu_s), before_mb, peak_mb);
}
