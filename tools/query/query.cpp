// SPDX-License-Identifier: MIT
#include "tools/command.h"
#include "tools/query/query.h"
#include "tools/query/run_query.h"

namespace alidade {
namespace {

ExitCode run(const QueryCommand& command) {
  const TargetFamily family = chosen_family(command);
  check_options(command, family);
  switch (family) {
    case TargetFamily::rays:
      return run_query<Ray>(command, family);
    case TargetFamily::cones:
      return run_query<Cone>(command, family);
    case TargetFamily::path:
      return run_query<Path>(command, family);
    case TargetFamily::planes:
      return run_query<HalfSpaces>(command, family);
    case TargetFamily::boxes:
      return run_query<Bounds>(command, family);
    case TargetFamily::points:
      break;
  }
  return run_query<glm::dvec3>(command, family);
}

}  // namespace

Command add_query(CLI::App& program) {
  CLI::App* query = program.add_subcommand(
      "query", "Find the points that rays, cones, paths, planes, boxes or places meet");
  const std::shared_ptr<QueryCommand> command = add_query_options(*query);
  query->footer(
      "Forms:\n"
      "  alidade query CLOUD... --rays FILE [CONDITIONS] [-o FILE]\n"
      "  alidade query CLOUD... --ray OX,OY,OZ,DX,DY,DZ [CONDITIONS] [-o FILE]\n"
      "and likewise with --cones, --path, --planes, --boxes, --points. One kind of target in a run.\n"
      "\n"
      "Lengths and coordinates are in metres (the unit of the cloud's CRS), half angles in degrees. All "
      "limits "
      "are inclusive.\n"
      "All conditions hold together. Directions and normals may have any length but zero. A target whose "
      "interval or box\n"
      "is inverted (t_min > t_max) has no answers.\n"
      "\n"
      "Targets, as a file, a pipe, or - for standard input:\n"
      "  CSV         a header with the names of the columns in any order, then one row per ray (cone, box, "
      "place),\n"
      "              vertex of a path, or plane of a region. Optional columns stand in [brackets]; an empty "
      "cell in one\n"
      "              is as if it were not there. Limits may be inf or -inf. Blank lines are skipped.\n"
      "      rays    ox,oy,oz,dx,dy,dz[,t_min][,t_max]\n"
      "      cones   ox,oy,oz,dx,dy,dz,half_angle[,radius][,t_min][,t_max]\n"
      "      path    x,y,z[,path]\n"
      "      planes  px,py,pz,nx,ny,nz[,region]\n"
      "      boxes   min_x,min_y,min_z,max_x,max_y,max_z\n"
      "      points  x,y,z\n"
      "  JSON lines  an object per line with these names as keys, or with vectors: origin and direction "
      "(rays, "
      "cones),\n"
      "              position (path, points), point and normal (planes), min and max (boxes); or an array in "
      "this order.\n"
      "\n"
      "Answers stand in the order of the targets, each target's by the measure and then by point id. Ids and "
      "ranks count\n"
      "from 0; point_id is the row of the cloud. Numbers have 17 significant digits. A target without an "
      "answer has no row,\n"
      "but with --count and --occluded one row.\n"
      "      rays    ray_id,rank,point_id,x,y,z,t,distance,entry    entry is -inf without --radius\n"
      "      cones   cone_id,rank,point_id,x,y,z,t,distance,entry\n"
      "      path    path_id,rank,point_id,x,y,z,segment,t,distance    t along the path from its first "
      "vertex\n"
      "      planes  region_id,rank,point_id,x,y,z,distance    to the region's first plane\n"
      "      boxes   box_id,rank,point_id,x,y,z\n"
      "      points  query_id,rank,point_id,x,y,z,distance\n"
      "      --count ray_id,count; --occluded ray_id,occluded (0 or 1); and so on\n"
      "  .jsonl      an object per row with the same keys; null for an infinite number\n"
      "  .las, .laz  LAS 1.4: a point per row with all its attributes and the extra bytes Distance (double), "
      "RayT (double)\n"
      "              and RayId (uint64); ConeT, ConeId, PathT, PathId, RegionId, BoxId, QueryId for the "
      "others\n"
      "\n"
      "Targets and answers are streamed: any number of them takes little memory. --explain asks by the plain "
      "form of\n"
      "Algorithm 1, whose steps are counted; answers are the same, but slower.\n"
      "\n"
      "Examples:\n"
      "  alidade query site.las --rays rays.csv --radius 0.05 --k 1 -o first_hits.csv\n"
      "  alidade query site.alidade --ray 0,0,30,0,0,-1 --radius 0.1 --measure t\n"
      "  alidade query site.las --path road.csv --radius 2 --class 2 -o profile.las\n"
      "  alidade query site.las --point 1.5,2,0 --k 8\n"
      "  make_rays | alidade query site.las --rays - --radius 0.05 --occluded > shadows.csv\n");
  return {query, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade
