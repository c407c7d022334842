// Poses to a running `chaincell serve` and forces back, in C#: for Unity, Mono and .NET on Linux.
//
// Put this file under Assets, and libchaincell_client.so.0 of the installed package (host/SIMULATOR.md) where the
// loader finds it, as by LD_LIBRARY_PATH. Call Step about a thousand times a second from a thread of its own: Update
// of a MonoBehaviour comes too seldom. The force falls to 0 by itself where the tissue does not answer; a device needs
// the rules of device_guard.hpp besides.
using System;
using System.Runtime.InteropServices;

namespace Chaincell
{
    /// chaincell_tool_pose: position [m], unit quaternion x, y, z, w, and 1 while the tool acts on the tissue.
    [StructLayout(LayoutKind.Sequential)]
    public struct ToolPose
    {
        public float X, Y, Z;
        public float Qx, Qy, Qz, Qw;
        public ushort Engaged, OpeningTurnsQ16;

        /// A pose from Unity's axes (left-handed, y up) in those of a scene whose z is up.
        public static ToolPose FromUnity(float x, float y, float z, float qx, float qy, float qz, float qw, bool engaged)
        {
            return new ToolPose
            {
                X = x, Y = z, Z = y, Qx = -qx, Qy = -qz, Qz = -qy, Qw = qw, Engaged = (ushort)(engaged ? 1 : 0)
            };
        }
    }

    /// chaincell_tool_output: force [N] and torque about the tool's position [N m] on a tool.
    [StructLayout(LayoutKind.Sequential)]
    public struct ToolOutput
    {
        public float ForceX, ForceY, ForceZ;
        public float TorqueX, TorqueY, TorqueZ;
        public uint Contacts, Flags;

        /// The force on Unity's axes [N].
        public void ForceToUnity(out float x, out float y, out float z)
        {
            x = ForceX;
            y = ForceZ;
            z = ForceY;
        }
    }

    /// chaincell_client_options.
    [StructLayout(LayoutKind.Sequential)]
    public struct Options
    {
        public int Role, Wait;
        public ulong ServerWaitNs;
        public uint WatchdogMs, RampMs;
    }

    /// chaincell_client_answer: what to show at a moment.
    [StructLayout(LayoutKind.Sequential)]
    public struct Answer
    {
        public ulong Tick, SessionId, ForceTick, StateHash, RoundTripNs, AgeNs, Answers;
        public float EnergyJ;
        public uint Flags, Notes, StepNs, Sweeps, Reserved;
        public ToolOutput Tool0, Tool1, Tool2, Tool3, Tool4, Tool5, Tool6, Tool7;
        public float ForceError0N, ForceError1N, ForceError2N, ForceError3N, ForceError4N, ForceError5N, ForceError6N, ForceError7N;
        public float TorqueError0NM, TorqueError1NM, TorqueError2NM, TorqueError3NM, TorqueError4NM, TorqueError5NM, TorqueError6NM, TorqueError7NM;
    }

    /// A scene, as its controller.
    public sealed class Session : IDisposable
    {
        const string Library = "libchaincell_client.so.0";
        public const uint Version = 1024;

        [DllImport(Library)]
        static extern int chaincell_client_open(uint version, string scene, ref Options options, out ulong client);

        [DllImport(Library)]
        static extern int chaincell_client_step(ulong client, [In] ToolPose[] poses, UIntPtr count, ulong waitNs, out Answer shown);

        [DllImport(Library)]
        static extern int chaincell_client_close(ulong client);

        [DllImport(Library)]
        static extern IntPtr chaincell_client_error_text(int code);

        readonly ulong client;

        /// Opens a scene and waits up to ten seconds for its server. Throws with the place and the remedy.
        public Session(string scene, uint watchdogMs = 20, uint rampMs = 20)
        {
            var options = new Options { ServerWaitNs = 10000000000, WatchdogMs = watchdogMs, RampMs = rampMs };
            Check(chaincell_client_open(Version, scene, ref options, out client));
        }

        /// Sends the poses of tools 0, 1 and so on, waits at most `waitNs`, and returns what to show. A tool has no force
        /// until a pose has released it once. Throws for a pose that is none.
        public Answer Step(ToolPose[] poses, ulong waitNs = 700000)
        {
            Check(chaincell_client_step(client, poses, (UIntPtr)poses.Length, waitNs, out var answer));
            return answer;
        }

        /// Leaves the scene: the server lets its force fall.
        public void Dispose()
        {
            chaincell_client_close(client);
        }

        static void Check(int code)
        {
            if (code < 0)
            {
                throw new InvalidOperationException(Marshal.PtrToStringAnsi(chaincell_client_error_text(code)));
            }
        }
    }
}
