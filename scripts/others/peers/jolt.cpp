// The sheet in Jolt, native: jolt FOLDER FRAMES FRAME GRAVITY NODE_MASS PIN PIN ITERATIONS COMPLIANCE SHEAR TETHERS.
// FOLDER has start.f32 and faces.u32; it gets frames.f32 and times.json. It does what jolt.mjs does.

#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseLayerInterfaceTable.h>
#include <Jolt/Physics/Collision/BroadPhase/ObjectVsBroadPhaseLayerFilterTable.h>
#include <Jolt/Physics/Collision/ObjectLayerPairFilterTable.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/Physics/SoftBody/SoftBodyCreationSettings.h>
#include <Jolt/Physics/SoftBody/SoftBodyMotionProperties.h>
#include <Jolt/RegisterTypes.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using namespace JPH;

template <class Number> static std::vector<Number> read(const std::string &path) {
	std::ifstream file(path, std::ios::binary);
	std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
	std::vector<Number> numbers(bytes.size() / sizeof(Number));
	std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char *>(numbers.data()));
	return numbers;
}

static double cpu() {
	timespec t;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
	return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

int main(int count, char **words) {
	if (count != 12)
		return 2;
	std::string folder = words[1];
	int frames = std::stoi(words[2]);
	float frame = std::stof(words[3]), gravity = std::stof(words[4]), mass = std::stof(words[5]);
	size_t pins[] = {std::stoul(words[6]), std::stoul(words[7])};
	uint iterations = uint(std::stoul(words[8]));
	float compliance = std::stof(words[9]), shear = std::stof(words[10]);
	bool tethers = std::stoi(words[11]) != 0;
	std::vector<float> start = read<float>(folder + "/start.f32");
	std::vector<uint32> faces = read<uint32>(folder + "/faces.u32");

	RegisterDefaultAllocator();
	Factory::sInstance = new Factory();
	RegisterTypes();
	TempAllocatorImpl temporary(64 * 1024 * 1024);
	JobSystemSingleThreaded jobs(cMaxPhysicsJobs);
	ObjectLayerPairFilterTable pairs(1); // one kind of object
	BroadPhaseLayerInterfaceTable layers(1, 1);
	layers.MapObjectToBroadPhaseLayer(0, BroadPhaseLayer(0));
	ObjectVsBroadPhaseLayerFilterTable meets(layers, 1, pairs, 1);
	PhysicsSystem system;
	system.Init(16, 0, 16, 16, layers, meets, pairs);
	system.SetGravity(Vec3(0, -gravity, 0));

	Ref<SoftBodySharedSettings> shared = new SoftBodySharedSettings;
	for (size_t i = 0; i < start.size() / 3; i++) {
		SoftBodySharedSettings::Vertex vertex;
		vertex.mPosition = Float3(start[3 * i], start[3 * i + 1], start[3 * i + 2]);
		vertex.mInvMass = i == pins[0] || i == pins[1] ? 0.0f : 1.0f / mass;
		shared->mVertices.push_back(vertex);
	}
	for (size_t i = 0; i < faces.size(); i += 3)
		shared->AddFace(SoftBodySharedSettings::Face(faces[i], faces[i + 1], faces[i + 2], 0));
	SoftBodySharedSettings::VertexAttributes attributes;
	attributes.mCompliance = compliance;
	attributes.mShearCompliance = shear;
	attributes.mLRAType = tethers ? SoftBodySharedSettings::ELRAType::GeodesicDistance : SoftBodySharedSettings::ELRAType::None;
	shared->CreateConstraints(&attributes, 1, SoftBodySharedSettings::EBendType::None);
	shared->Optimize();
	SoftBodyCreationSettings creation(shared, RVec3::sZero(), Quat::sIdentity(), 0);
	creation.mNumIterations = iterations;
	creation.mLinearDamping = 0.0f;
	creation.mUpdatePosition = false;
	creation.mAllowSleeping = false;
	Body *body = system.GetBodyInterface().CreateSoftBody(creation);
	system.GetBodyInterface().AddBody(body->GetID(), EActivation::Activate);

	const SoftBodyMotionProperties *motion = static_cast<const SoftBodyMotionProperties *>(body->GetMotionProperties());
	std::vector<float> out = start;
	double used = 0.0, wall = 0.0;
	for (int i = 0; i < frames; i++) {
		double before = cpu();
		auto since = std::chrono::steady_clock::now();
		system.Update(frame, 1, &temporary, &jobs);
		wall += std::chrono::duration<double>(std::chrono::steady_clock::now() - since).count();
		used += cpu() - before;
		for (const SoftBodyVertex &vertex : motion->GetVertices())
			for (int axis = 0; axis < 3; axis++)
				out.push_back(vertex.mPosition[axis]);
	}
	std::ofstream(folder + "/frames.f32", std::ios::binary).write(reinterpret_cast<const char *>(out.data()), std::streamsize(4 * out.size()));
	std::ofstream(folder + "/times.json") << "{\"cpu\": " << used << ", \"wall\": " << wall << "}";
}
