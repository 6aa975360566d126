/* Takes a CAN controller off its bus, as its driver does when the controller says that it has left: no emulated one
 * ever does. Everything behind that is the kernel's and the driver's own: error frame, carrier, the restart after
 * restart-ms, and the controller's new start.
 *
 *   echo can0 >/sys/module/can_bus_off/parameters/interface
 */
#include <linux/can/dev.h>
#include <linux/module.h>
#include <linux/netdevice.h>

static void leave_bus(struct net_device *device)
{
    struct can_frame *frame;
    struct sk_buff *buffer = alloc_can_err_skb(device, &frame);

    can_change_state(device, buffer ? frame : NULL, CAN_STATE_BUS_OFF, CAN_STATE_BUS_OFF);
    if (buffer) {
        netif_rx(buffer);
    }
    can_bus_off(device);
}

static int set_interface(const char *text, const struct kernel_param *parameter)
{
    char name[IFNAMSIZ];
    struct net_device *device;

    strscpy(name, text, sizeof name);
    device = dev_get_by_name(&init_net, strim(name));
    if (!device) {
        return -ENODEV;
    }
    local_bh_disable();
    if (device->flags & IFF_UP) {
        leave_bus(device);
    }
    local_bh_enable();
    dev_put(device);
    return 0;
}

static const struct kernel_param_ops interface_ops = {.set = set_interface};
module_param_cb(interface, &interface_ops, NULL, 0200);
MODULE_DESCRIPTION("takes a CAN controller off its bus");
MODULE_LICENSE("GPL");
