// Times CGAL's smooth_shape: one step from scratch, and four.
//
// Usage: smooth_shape MESH.ply TIME PATIENCE
// TIME is the diffusion time of a step in the units of M - TIME L, with the barycentric mass M and the
// cotangent Laplacian L. smooth_shape has half of this mass and twice this Laplacian (compared with
// libigl's matrices: the solutions agree at a quarter of the time). Where one step takes longer than PATIENCE seconds, four are
// not tried. The result is one line of JSON, as from competitors.py.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/smooth_shape.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/PLY.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Resident memory in bytes; `field` is VmRSS (now) or VmHWM (largest so far).
static double resident_memory(const std::string& field) {
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line)) {
        if (line.compare(0, field.size(), field) == 0) {
            return 1024 * std::stod(line.substr(field.size() + 1));
        }
    }
    return 0;
}

static double seconds_of_smoothing(Mesh& mesh, double time, unsigned int steps) {
    const auto start = std::chrono::steady_clock::now();
    CGAL::Polygon_mesh_processing::smooth_shape(
        faces(mesh), mesh, time, CGAL::parameters::number_of_iterations(steps));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

static double root_mean_square_move(const Mesh& before, const Mesh& after) {
    double sum = 0;
    for (const auto vertex : before.vertices()) {
        sum += CGAL::squared_distance(before.point(vertex), after.point(vertex));
    }
    return std::sqrt(sum / before.number_of_vertices());
}

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: smooth_shape MESH.ply TIME PATIENCE\n";
        return 2;
    }
    Mesh original;
    std::ifstream file(argv[1], std::ios::binary);
    if (!CGAL::IO::read_PLY(file, original)) {
        std::cerr << "cannot read " << argv[1] << "\n";
        return 1;
    }
    const double time = std::atof(argv[2]) / 4, patience = std::atof(argv[3]);
    const double before = resident_memory("VmRSS");

    Mesh smoothed = original;
    std::clock_t start = std::clock();
    const double one = seconds_of_smoothing(smoothed, time, 1);
    double four = 0;
    if (one <= patience) {
        smoothed = original;
        start = std::clock();
        four = seconds_of_smoothing(smoothed, time, 4);
    }
    const double processor = double(std::clock() - start) / CLOCKS_PER_SEC;
    std::cout << "{\"one\": " << one << ", \"four\": ";
    if (four > 0) {
        std::cout << four;
    } else {
        std::cout << "null";
    }
    std::cout << ", \"processor\": " << processor
              << ", \"moved\": " << root_mean_square_move(original, smoothed)
              << ", \"before\": " << before << ", \"peak\": " << resident_memory("VmHWM") << "}\n";
}
